#include "core/io/text_reader.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/io/input_file.h"

namespace arborslam {
namespace {

// A file without line ends must not be taken into memory whole.
constexpr size_t kMaxLineLength = 1 << 16;

// std::from_chars with the leading '+' that std::strtod takes and from_chars does not.
template <typename T>
bool Parse(const std::string& text, T* value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++begin;
  const std::from_chars_result result = std::from_chars(begin, end, *value);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

TextReader::TextReader(const std::string& path) : path_(path), stream_(OpenInputFile(path)), line_(kMaxLineLength) {}

bool TextReader::Next() {
  constexpr char kSpace[] = " \t\r\v\f";
  fields_.clear();
  while (fields_.empty()) {
    stream_.getline(line_.data(), static_cast<std::streamsize>(line_.size()));
    if (stream_.bad()) throw UserError(path_, "cannot be read to its end", "check the storage");
    if (stream_.fail() && stream_.eof()) return false;
    ++line_number_;
    if (stream_.fail()) {
      throw UserError(Place(), "is longer than " + std::to_string(kMaxLineLength - 1) + " characters",
                      "check that this is a text file of the right kind");
    }
    const std::streamsize length = stream_.gcount() - (stream_.eof() ? 0 : 1);  // Without the line's end.
    if (std::strlen(line_.data()) != static_cast<size_t>(length)) {
      throw UserError(Place(), "holds a zero byte", "check that this is a text file of the right kind");
    }
    const char* field = line_.data();
    if (line_number_ == 1) field += ByteOrderMarkLength(line_.data());
    field += std::strspn(field, kSpace);
    if (*field == '#') continue;
    while (*field != '\0') {
      const size_t field_length = std::strcspn(field, kSpace);
      fields_.emplace_back(field, field_length);
      field += field_length;
      field += std::strspn(field, kSpace);
    }
  }
  return true;
}

std::string TextReader::Place(size_t line_number) const { return path_ + ", line " + std::to_string(line_number); }

void TextReader::ExpectFields(size_t count, const std::string& layout) const {
  if (fields_.size() == count) return;
  throw UserError(Place(), "has " + std::to_string(fields_.size()) + " columns instead of " + std::to_string(count),
                  "write it as '" + layout + "'");
}

double TextReader::Number(size_t index, const std::string& name) const {
  double value = 0.0;
  if (!Parse(fields_.at(index), &value)) {
    throw UserError(Place(), name + " " + Quoted(fields_[index]) + " is not a number", "correct or remove the line");
  }
  if (!std::isfinite(value)) {
    throw UserError(Place(), name + " " + Quoted(fields_[index]) + " is not finite", "correct or remove the line");
  }
  return value;
}

int TextReader::Integer(size_t index, const std::string& name) const {
  int value = 0;
  if (!Parse(fields_.at(index), &value)) {
    double number = 0.0;
    const bool is_too_great =
        fields_[index].find_first_not_of("+-0123456789") == std::string::npos && Parse(fields_[index], &number);
    if (is_too_great) {
      throw UserError(Place(), name + " " + Quoted(fields_[index]) + " is beyond what is supported",
                      "number from " + std::to_string(std::numeric_limits<int>::min()) + " to " +
                          std::to_string(std::numeric_limits<int>::max()));
    }
    throw UserError(Place(), name + " " + Quoted(fields_[index]) + " is not an integer", "correct or remove the line");
  }
  return value;
}

std::string ShortestText(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof(text), value).ptr);
}

}  // namespace arborslam
