#include "core/config/validation.h"

#include <array>
#include <charconv>
#include <cmath>

namespace arborslam {

std::string FormatDouble(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  std::array<char, 32> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), end);
  // YAML 1.1 readers take "1e-05" for a string and "20" for an integer.
  if (text.find('.') == std::string::npos) {
    const size_t exponent = text.find('e');
    text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  }
  return text;
}

std::string Violation(const std::string& key, double value, const std::string& requirement) {
  return key + " is " + FormatDouble(value) + ", must " + requirement;
}

std::string Violation(const std::string& key, int value, const std::string& requirement) {
  return key + " is " + std::to_string(value) + ", must " + requirement;
}

std::string Violation(const std::string& key, const std::string& value, const std::string& requirement) {
  return key + " is '" + value + "', must " + requirement;
}

}  // namespace arborslam
