#include "core/io/cloud_layout.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/io/input_file.h"
#include "core/io/sweep_points.h"

namespace arborslam {
namespace {

using Encoding = CloudLayout::Encoding;
using Words = std::vector<std::string_view>;

constexpr size_t kMaxHeader = 1 << 16;                // [bytes]
constexpr size_t kMaxPointSize = 1 << 16;             // [bytes]
constexpr size_t kMaxLzfGain = 88;                    // Three bytes of LZF stand for at most 264.
constexpr uint64_t kMaxUnpacked = uint64_t{1} << 30;  // [bytes]
constexpr char kDamaged[] = "check that it was copied completely";
constexpr char kNoHeader[] = "check that this is a point cloud of the kind that its name says";

Words Split(std::string_view line) {
  constexpr std::string_view kSpace = " \t\r\v\f";
  Words words;
  for (size_t begin = line.find_first_not_of(kSpace); begin != std::string_view::npos;) {
    const size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSpace, end);
  }
  return words;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

// The lines of a header, one by one, with what an error about them needs.
class HeaderReader {
 public:
  HeaderReader(const std::string& path, std::string_view contents)
      : path_(path), contents_(contents), position_(ByteOrderMarkLength(contents)) {}

  // The words of the next line that has any. Throws at the end of the file or of what a header may be long.
  Words Next() {
    while (true) {
      const size_t end = contents_.substr(0, kMaxHeader).find('\n', position_);
      if (end == std::string_view::npos) {
        throw UserError(path_, "has no complete header in its first " + std::to_string(kMaxHeader) + " bytes",
                        kNoHeader);
      }
      const Words words = Split(contents_.substr(position_, end - position_));
      position_ = end + 1;
      ++line_;
      if (!words.empty()) return words;
    }
  }

  size_t position() const { return position_; }
  size_t line() const { return line_; }

  [[noreturn]] void Fail(const std::string& problem, const std::string& remedy = kNoHeader) const {
    throw UserError(path_ + ", line " + std::to_string(line_), problem, remedy);
  }

  uint64_t Number(std::string_view word) const {
    uint64_t value = 0;
    const std::from_chars_result result = std::from_chars(word.data(), word.data() + word.size(), value);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size()) {
      Fail(Quoted(std::string(word)) + " is no whole number of at most 64 bits");
    }
    return value;
  }

 private:
  const std::string& path_;
  std::string_view contents_;
  size_t position_ = 0;
  size_t line_ = 0;
};

bool IsValidType(char type, uint64_t size) {
  if (type == 'F') return size == 4 || size == 8;
  if (type == 'I' || type == 'U') return size == 1 || size == 2 || size == 4 || size == 8;
  return false;
}

// Offsets and the point's size, from sizes and counts.
void LayOut(const HeaderReader& header, CloudLayout* layout) {
  layout->point_size = 0;
  for (CloudField& field : layout->fields) {
    field.offset = layout->point_size;
    const size_t value_size = layout->encoding == Encoding::kText ? 1 : field.size;
    if (field.count == 0 || field.count > kMaxPointSize) {
      header.Fail("field " + Quoted(field.name) + " has " + std::to_string(field.count) + " values");
    }
    layout->point_size += value_size * field.count;
    if (layout->point_size > kMaxPointSize) {
      header.Fail("its points are longer than " + std::to_string(kMaxPointSize) + " bytes");
    }
  }
}

[[noreturn]] void FailForRoom(const std::string& path, uint64_t claimed, uint64_t found) {
  throw UserError(
      path,
      "should have " + std::to_string(claimed) + " points by its header but has room for " + std::to_string(found),
      kDamaged);
}

// Throws unless the body is as long as the header claims.
void CheckRoom(const std::string& path, std::string_view contents, const CloudLayout& layout) {
  RequireSweepSize(path, layout.num_points);
  const uint64_t length = contents.size() - layout.body;
  const uint64_t num_points = layout.num_points;
  const uint64_t size = num_points * layout.point_size;  // At most 2^24 x 2^16.
  if (layout.encoding == Encoding::kText) {
    // A digit and a space, but for the last.
    if (size > (length + 1) / 2) FailForRoom(path, num_points, (length + 1) / 2 / layout.point_size);
    return;
  }
  if (layout.encoding != Encoding::kCompressedColumns) {
    const uint64_t room = length / layout.point_size;
    // PCL's own writer leaves a page of zeros at the end on some file systems.
    const std::string_view rest = contents.substr(std::min<uint64_t>(contents.size(), layout.body + size));
    const bool is_padding = layout.has_more || rest.find_first_not_of('\0') == std::string_view::npos;
    if (room < num_points || (room > num_points && !is_padding)) FailForRoom(path, num_points, room);
    return;
  }
  if (num_points == 0) return;
  uint32_t sizes[2] = {0, 0};
  if (length < sizeof(sizes)) throw UserError(path, "ends before its compressed points", kDamaged);
  std::memcpy(sizes, contents.data() + layout.body, sizeof(sizes));
  if (sizes[0] > length - sizeof(sizes)) {
    throw UserError(path,
                    "should have " + std::to_string(sizes[0]) + " bytes of compressed points but has " +
                        std::to_string(length - sizeof(sizes)),
                    kDamaged);
  }
  if (sizes[1] != size) {
    throw UserError(path,
                    "has " + std::to_string(sizes[1]) + " bytes of points when unpacked, but " + std::to_string(size) +
                        " by its header",
                    kDamaged);
  }
  if (size > std::min(kMaxUnpacked, uint64_t{kMaxLzfGain} * sizes[0])) {
    throw UserError(path,
                    "claims to unpack " + std::to_string(sizes[0]) + " bytes to " + std::to_string(size) +
                        ", more than can be or more than a sweep has",
                    kDamaged);
  }
}

CloudLayout ParsePcdHeader(const std::string& path, std::string_view contents) {
  HeaderReader header(path, contents);
  CloudLayout layout;
  std::map<std::string, std::vector<std::string>> entries;
  while (entries.count("DATA") == 0) {
    const Words words = header.Next();
    if (words[0][0] == '#') continue;
    const std::string key = words[0] == "COLUMNS" ? "FIELDS" : std::string(words[0]);
    constexpr const char* kKeys[] = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                     "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
    if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys)) {
      header.Fail(Quoted(key) + " is no keyword of a PCD header");
    }
    if (!entries.emplace(key, std::vector<std::string>(words.begin() + 1, words.end())).second) {
      header.Fail(key + " is there twice");
    }
    if (words.size() < 2) header.Fail(key + " says nothing");
  }
  layout.body = header.position();
  layout.lines_before_body = header.line();

  const std::string& encoding = entries["DATA"][0];
  if (encoding == "ascii") {
    layout.encoding = Encoding::kText;
  } else if (encoding == "binary") {
    layout.encoding = Encoding::kBinary;
  } else if (encoding == "binary_compressed") {
    layout.encoding = Encoding::kCompressedColumns;
  } else {
    header.Fail("DATA is " + Quoted(encoding), "give ascii, binary or binary_compressed");
  }

  if (entries.count("FIELDS") == 0) header.Fail("the header has no FIELDS");
  for (const std::string& name : entries["FIELDS"]) {
    layout.fields.emplace_back();
    layout.fields.back().name = name;
  }
  for (const char* key : {"SIZE", "TYPE", "COUNT"}) {
    if (entries.count(key) != 0 && entries[key].size() != layout.fields.size()) {
      header.Fail(std::string(key) + " has " + std::to_string(entries[key].size()) + " entries for " +
                  std::to_string(layout.fields.size()) + " fields");
    }
  }
  bool has_void = false;
  for (size_t i = 0; i < layout.fields.size(); ++i) {
    CloudField& field = layout.fields[i];
    const std::string type = entries.count("TYPE") != 0 ? entries["TYPE"][i] : "F";
    const uint64_t size = entries.count("SIZE") != 0 ? header.Number(entries["SIZE"][i]) : 4;
    if (type.size() != 1 || !IsValidType(type[0], size)) {
      header.Fail("field " + Quoted(field.name) + " is of type " + Quoted(type) + " and size " + std::to_string(size),
                  "give F of 4 or 8 bytes, or I or U of 1, 2, 4 or 8");
    }
    field.type = type[0];
    field.size = size;
    field.count = entries.count("COUNT") != 0 ? header.Number(entries["COUNT"][i]) : 1;
    has_void |= field.count == 0;
    // The points are not stored with their gaps then, and no two programs agree on what is.
    if (field.name == "_" && layout.encoding == Encoding::kCompressedColumns) {
      header.Fail("compressed points have the unused field '_'", "write the file without it, or uncompressed");
    }
  }
  // A field without values takes no room.
  if (has_void) {
    layout.fields.erase(std::remove_if(layout.fields.begin(), layout.fields.end(),
                                       [](const CloudField& field) { return field.count == 0; }),
                        layout.fields.end());
  }
  LayOut(header, &layout);

  const auto number = [&](const std::string& key, uint64_t otherwise) {
    return entries.count(key) != 0 ? header.Number(entries[key][0]) : otherwise;
  };
  if (entries.count("POINTS") == 0 && entries.count("WIDTH") == 0)
    header.Fail("the header has neither POINTS nor WIDTH");
  const uint64_t height = number("HEIGHT", 1);
  const uint64_t width = number("WIDTH", number("POINTS", 0));
  uint64_t num_points = 0;
  if (__builtin_mul_overflow(width, height, &num_points) || num_points != number("POINTS", num_points)) {
    header.Fail("WIDTH " + std::to_string(width) + " x HEIGHT " + std::to_string(height) + " are not POINTS " +
                std::to_string(number("POINTS", 0)));
  }
  RequireSweepSize(path, num_points);
  layout.num_points = num_points;
  return layout;
}

std::optional<std::pair<char, size_t>> PlyType(std::string_view name) {
  static const std::map<std::string_view, std::pair<char, size_t>> kTypes = {
      {"char", {'I', 1}},    {"int8", {'I', 1}},   {"uchar", {'U', 1}},  {"uint8", {'U', 1}},  {"short", {'I', 2}},
      {"int16", {'I', 2}},   {"ushort", {'U', 2}}, {"uint16", {'U', 2}}, {"int", {'I', 4}},    {"int32", {'I', 4}},
      {"uint", {'U', 4}},    {"uint32", {'U', 4}}, {"int64", {'I', 8}},  {"uint64", {'U', 8}}, {"float", {'F', 4}},
      {"float32", {'F', 4}}, {"double", {'F', 8}}, {"float64", {'F', 8}}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

CloudLayout ParsePlyHeader(const std::string& path, std::string_view contents) {
  struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<CloudField> fields;
    bool has_list = false;
  };
  HeaderReader header(path, contents);
  header.Next();
  CloudLayout layout;
  bool has_format = false;
  std::vector<Element> elements;
  for (Words words = header.Next(); words[0] != "end_header"; words = header.Next()) {
    const std::string key(words[0]);
    if (key == "comment" || key == "obj_info") continue;
    if (key == "format" && words.size() == 3 && !has_format) {
      has_format = true;
      if (words[1] == "ascii") {
        layout.encoding = Encoding::kText;
      } else if (words[1] == "binary_little_endian") {
        layout.encoding = Encoding::kBinary;
      } else if (words[1] == "binary_big_endian") {
        layout.encoding = Encoding::kBigEndian;
      } else {
        header.Fail("the format is " + Quoted(std::string(words[1])),
                    "give ascii, binary_little_endian or binary_big_endian");
      }
    } else if (key == "element" && words.size() == 3) {
      elements.push_back({std::string(words[1]), header.Number(words[2]), {}, false});
    } else if (key == "property" && words.size() == 3 && !elements.empty()) {
      const std::optional<std::pair<char, size_t>> type = PlyType(words[1]);
      if (!type) header.Fail(Quoted(std::string(words[1])) + " is no type of a PLY property");
      elements.back().fields.push_back({std::string(words[2]), type->first, type->second, 1, 0});
    } else if (key == "property" && words.size() == 5 && words[1] == "list" && !elements.empty()) {
      elements.back().has_list = true;
    } else {
      header.Fail(Quoted(key) + " is no line of a PLY header, or out of place");
    }
  }
  if (!has_format) header.Fail("the header has no format");
  layout.body = header.position();
  layout.lines_before_body = header.line();

  for (Element& element : elements) {
    const bool is_vertex = element.name == "vertex";
    // What follows the points may be laid out as it likes.
    if (element.has_list) {
      header.Fail(
          "element " + Quoted(element.name) + " has lists of varying length, so that the points cannot be found",
          "write the vertices first and without lists");
    }
    layout.fields = std::move(element.fields);
    LayOut(header, &layout);
    if (is_vertex) {
      RequireSweepSize(path, element.count);
      layout.num_points = element.count;
      layout.has_more = element.name != elements.back().name;
      if (layout.fields.empty()) header.Fail("the vertices have no properties");
      return layout;
    }
    if (layout.encoding == Encoding::kText) {
      // A line has two bytes at least.
      if (element.count > contents.size()) FailForRoom(path, element.count, contents.size());
      layout.lines_to_skip += element.count;
    } else {
      uint64_t size = 0;
      if (__builtin_mul_overflow(element.count, uint64_t{layout.point_size}, &size) ||
          size > contents.size() - layout.body) {
        throw UserError(path, "ends before its vertices", kDamaged);
      }
      layout.body += size;
    }
  }
  header.Fail("the header has no element 'vertex'", "give a PLY file of points");
}

}  // namespace

const CloudField* CloudLayout::Find(std::string_view name) const {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const CloudField& field) { return LowerCase(field.name) == name; });
  return found == fields.end() ? nullptr : &*found;
}

bool LooksLikePcd(std::string_view contents) {
  contents.remove_prefix(ByteOrderMarkLength(contents));
  for (const std::string_view beginning : {"# .PCD", "VERSION", "FIELDS", "COLUMNS"}) {
    if (contents.substr(0, beginning.size()) == beginning) return true;
  }
  return false;
}

bool LooksLikePly(std::string_view contents) {
  contents.remove_prefix(ByteOrderMarkLength(contents));
  if (contents.substr(0, 3) != "ply") return false;
  const size_t end = contents.find_first_not_of(" \t", 3);
  return end != std::string_view::npos && (contents[end] == '\n' || contents[end] == '\r');
}

CloudLayout ParseCloudHeader(const std::string& path, std::string_view contents) {
  const CloudLayout layout = LooksLikePly(contents) ? ParsePlyHeader(path, contents) : ParsePcdHeader(path, contents);
  CheckRoom(path, contents, layout);
  return layout;
}

}  // namespace arborslam
