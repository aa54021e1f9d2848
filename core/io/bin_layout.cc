#include "core/io/bin_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string_view>

#include "core/error.h"
#include "core/io/input_file.h"

namespace arborslam {
namespace {

constexpr size_t kMostBytes = size_t{1} << 20;  // Read of each file.
constexpr double kPlausibleShare = 0.98;        // Of the values.
// Magnitudes that a coordinate, an intensity, a ring or a time of a sweep has.
constexpr double kLeastValue = 1e-6;
constexpr double kGreatestValue = 1e6;
// KITTI's layout is taken when its columns differ at least this share of how the best one's do.
constexpr double kKittiShare = 0.7;
// Another is taken when the next one's differ no more than this share of how its do.
constexpr double kClearShare = 0.7;
constexpr size_t kMinValues = 60;  // With fewer nothing can be told.
// Columns that differ less are none, as where all x come before all y; with fewer values they may by chance.
constexpr double kLeastContrast = 0.02;
constexpr size_t kManyValues = 2000;

struct Type {
  size_t size;
  bool is_big_endian;
};
constexpr Type kTypes[] = {{4, false}, {8, false}, {4, true}, {8, true}};

std::string FirstBytes(const std::string& path) {
  try {
    std::ifstream stream = OpenInputFile(path);
    std::string bytes(kMostBytes, '\0');
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<size_t>(stream.gcount()));
    return bytes;
  } catch (const UserError&) {
    return "";
  }
}

std::vector<double> Decode(std::string_view bytes, const Type& type) {
  std::vector<double> values;
  values.reserve(bytes.size() / type.size);
  for (size_t i = 0; i + type.size <= bytes.size(); i += type.size) {
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), bytes.data() + i, type.size);
    if (type.is_big_endian) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(type.size));
    if (type.size == 4) {
      float value = 0.0f;
      std::memcpy(&value, raw.data(), sizeof(value));
      values.push_back(static_cast<double>(value));
    } else {
      double value = 0.0;
      std::memcpy(&value, raw.data(), sizeof(value));
      values.push_back(value);
    }
  }
  return values;
}

// Not a number is a usual way to say that nothing came back.
bool IsPlausible(double value) {
  const double size = std::abs(value);
  return std::isnan(value) || size == 0.0 || (size >= kLeastValue && size <= kGreatestValue);
}

// How much of the variance of magnitudes and signs lies between the columns of rows of `width` values, in [0, 1].
double ColumnContrast(const std::vector<std::vector<double>>& files, size_t width) {
  double contrast = 0.0;
  for (const bool of_signs : {false, true}) {
    std::vector<double> sums(width, 0.0);
    std::vector<double> counts(width, 0.0);
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    for (const std::vector<double>& values : files) {
      for (size_t i = 0; i < values.size(); ++i) {
        if (!std::isfinite(values[i])) continue;
        const double magnitude = std::log10(std::clamp(std::abs(values[i]), 1e-3, 1e4));
        const double feature = of_signs ? (values[i] < 0.0 ? 1.0 : 0.0) : magnitude;
        sums[i % width] += feature;
        counts[i % width] += 1.0;
        sum += feature;
        squares += feature * feature;
        count += 1.0;
      }
    }
    if (count < 1.0) continue;
    const double variance = squares / count - (sum / count) * (sum / count);
    double between = 0.0;
    for (size_t c = 0; c < width; ++c) {
      if (counts[c] < 1.0) continue;
      const double difference = sums[c] / counts[c] - sum / count;
      between += counts[c] / count * difference * difference;
    }
    if (variance > 1e-12) contrast += between / variance;
  }
  return 0.5 * contrast;
}

}  // namespace

std::string BinLayout::Name() const {
  return std::to_string(num_values) + " x float" + std::to_string(8 * value_size) +
         (is_big_endian ? ", big-endian" : "");
}

bool ParseBinLayout(const std::string& name, BinLayout* layout) {
  for (size_t num_values = 3; num_values <= 6; ++num_values) {
    for (const Type& type : kTypes) {
      const BinLayout candidate{num_values, type.size, type.is_big_endian};
      if (candidate.Name() != name) continue;
      *layout = candidate;
      return true;
    }
  }
  return false;
}

BinLayout FindBinLayout(const std::vector<std::string>& paths) {
  std::vector<std::string> contents;
  for (const std::string& path : paths) contents.push_back(FirstBytes(path));
  std::string shares;  // For a message.
  for (const Type& type : kTypes) {
    std::vector<std::vector<double>> files;
    size_t num_values = 0;
    size_t num_plausible = 0;
    for (const std::string& bytes : contents) {
      files.push_back(Decode(bytes, type));
      num_values += files.back().size();
      num_plausible += static_cast<size_t>(std::count_if(files.back().begin(), files.back().end(), &IsPlausible));
    }
    if (num_values < kMinValues) return {};
    const double share = static_cast<double>(num_plausible) / static_cast<double>(num_values);
    const BinLayout of_type{4, type.size, type.is_big_endian};
    char text[64];
    std::snprintf(text, sizeof(text), "%s%.0f %% as %s", shares.empty() ? "" : ", ", 100.0 * share,
                  of_type.Name().substr(4).c_str());
    shares += text;
    if (share < kPlausibleShare) continue;
    std::array<double, 7> contrasts{};
    size_t best = 4;
    for (size_t width = 3; width <= 6; ++width) {
      contrasts[width] = ColumnContrast(files, width);
      // Twice as many columns differ as much, by chance a little more.
      const bool is_double = width == 6 && contrasts[6] < 1.1 * contrasts[3];
      if (contrasts[width] > contrasts[best] && !is_double) best = width;
    }
    if (num_values >= kManyValues && contrasts[best] < kLeastContrast) {
      throw UserError(
          paths.front(), "holds no points side by side: its columns do not differ at any width",
          "give x, y, z and what follows point by point, or state the layout with --set input.layout=\"...\"");
    }
    if (of_type.IsKitti() && contrasts[4] >= kKittiShare * contrasts[best]) return {};
    for (size_t width = 3; width <= 6; ++width) {
      if (width == best || width == 2 * best || 2 * width == best) continue;
      if (contrasts[width] <= kClearShare * contrasts[best]) continue;
      throw UserError(paths.front(),
                      "may have points of " + BinLayout{best, type.size, type.is_big_endian}.Name() + " or of " +
                          BinLayout{width, type.size, type.is_big_endian}.Name(),
                      "state which with --set input.layout=\"...\"");
    }
    return {best, type.size, type.is_big_endian};
  }
  throw UserError(paths.front(),
                  "does not hold numbers of any known layout (plausible values in the first sweeps: " + shares + ")",
                  "give 4 little-endian float32 (x, y, z, intensity) for each point, or state input.layout");
}

}  // namespace arborslam
