#include "core/io/map_io.h"

#include <glog/logging.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <locale>
#include <ostream>
#include <set>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/input_file.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr double kOccupiedThreshold = 0.65;
constexpr double kFreeThreshold = 0.196;
constexpr uint8_t kOccupiedPixel = 0;
constexpr uint8_t kFreePixel = 254;
constexpr uint8_t kUnknownPixel = 205;
constexpr std::streamsize kMaxYamlBytes = 1 << 16;

struct Pgm {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> pixels;  // Row 0 is the top one.
};

struct MapDescription {
  std::string image;
  double resolution = 0.0;
  double origin_x = 0.0;
  double origin_y = 0.0;
  bool negate = false;
  double occupied_threshold = 0.0;
  double free_threshold = 0.0;
};

uint8_t ToPixel(uint8_t percent) {
  if (percent == GridImage::kUnknown) return kUnknownPixel;
  CHECK_LE(percent, 100) << "percent of occupancy";
  const double probability = percent / 100.0;
  if (probability > kOccupiedThreshold) return kOccupiedPixel;
  return probability < kFreeThreshold ? kFreePixel : kUnknownPixel;
}

uint8_t ToPercent(uint8_t pixel, const MapDescription& description) {
  const double probability = (description.negate ? pixel : 255 - pixel) / 255.0;
  if (probability > description.occupied_threshold) return 100;
  return probability < description.free_threshold ? 0 : GridImage::kUnknown;
}

std::string PlaceOf(const std::string& path, const std::string& key) { return path + ", key '" + key + "'"; }

// The value of `key`, which must be there and be a T.
template <typename T>
T Value(const YAML::Node& map, const std::string& path, const std::string& key, const std::string& kind) {
  const YAML::Node node = map[key];
  if (!node) throw UserError(path, "has no key '" + key + "'", "add it as " + kind);
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    throw UserError(PlaceOf(path, key),
                    node.IsScalar() ? "has the value " + Quoted(node.Scalar()) : "has no value of its kind",
                    "give " + kind);
  }
}

double Threshold(const YAML::Node& map, const std::string& path, const std::string& key) {
  const double value = Value<double>(map, path, key, "a probability from 0 to 1");
  if (!(value >= 0.0 && value <= 1.0)) {
    throw UserError(PlaceOf(path, key), "has the value " + ShortestText(value), "give a probability from 0 to 1");
  }
  return value;
}

MapDescription Interpret(const YAML::Node& map, const std::string& path) {
  if (!map.IsMap()) throw UserError(path, "is not a map description", "give the .yaml file of a map_server map");
  std::set<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
    if (!seen.insert(key).second) throw UserError(path, "has the key " + Quoted(key) + " twice", "remove one");
  }
  MapDescription description;
  description.image = Value<std::string>(map, path, "image", "the name of a .pgm file");
  description.resolution = Value<double>(map, path, "resolution", "metres a cell");
  if (!std::isfinite(description.resolution) || description.resolution <= 0.0) {
    throw UserError(PlaceOf(path, "resolution"), "has the value " + ShortestText(description.resolution),
                    "give metres a cell, more than 0");
  }
  const std::vector<double> origin = Value<std::vector<double>>(map, path, "origin", "[x, y, yaw]");
  if (origin.size() != 3 || !std::all_of(origin.begin(), origin.end(), [](double v) { return std::isfinite(v); })) {
    throw UserError(PlaceOf(path, "origin"), "is not three finite numbers", "give [x, y, yaw]");
  }
  if (origin[2] != 0.0) {
    throw UserError(PlaceOf(path, "origin"), "has the yaw " + ShortestText(origin[2]),
                    "give a map that is not rotated, with yaw 0");
  }
  description.origin_x = origin[0];
  description.origin_y = origin[1];
  const int negate = Value<int>(map, path, "negate", "0 or 1");
  if (negate != 0 && negate != 1) {
    throw UserError(PlaceOf(path, "negate"), "has the value " + std::to_string(negate), "give 0 or 1");
  }
  description.negate = negate == 1;
  description.occupied_threshold = Threshold(map, path, "occupied_thresh");
  description.free_threshold = Threshold(map, path, "free_thresh");
  if (description.free_threshold > description.occupied_threshold) {
    throw UserError(PlaceOf(path, "free_thresh"),
                    "has the value " + ShortestText(description.free_threshold) + ", above occupied_thresh",
                    "give a smaller one");
  }
  if (map["mode"]) {
    const std::string mode = Value<std::string>(map, path, "mode", "trinary");
    if (mode != "trinary") {
      throw UserError(PlaceOf(path, "mode"), "has the value " + Quoted(mode), "give a map of mode trinary");
    }
  }
  return description;
}

MapDescription ReadDescription(const std::string& path) {
  std::ifstream stream = OpenInputFile(path);
  std::string text(static_cast<size_t>(kMaxYamlBytes) + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.gcount() > kMaxYamlBytes) {
    throw UserError(path, "is too long for a map description", "give the .yaml file, not the picture");
  }
  text.resize(static_cast<size_t>(stream.gcount()));
  try {
    return Interpret(YAML::Load(text), path);
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : ", line " + std::to_string(error.mark.line + 1);
    throw UserError(path + line, "is not valid YAML: " + error.msg, "correct it");
  }
}

// A number of a PGM header, after white space and comments.
int HeaderNumber(std::istream& stream, const std::string& path) {
  stream >> std::ws;
  while (stream.peek() == '#') {
    while (stream && stream.get() != '\n') continue;
    stream >> std::ws;
  }
  int number = 0;
  if (!(stream >> number) || number <= 0) {
    throw UserError(path, "has a malformed PGM header", "save the picture as binary PGM (P5)");
  }
  return number;
}

Pgm ReadPgm(const std::string& path) {
  std::ifstream stream = OpenInputFile(path);
  stream.imbue(std::locale::classic());
  char magic[2] = {};
  stream.read(magic, sizeof(magic));
  if (magic[0] != 'P' || magic[1] != '5') {
    throw UserError(path, "is not a binary PGM picture", "save the picture as binary PGM (P5)");
  }
  Pgm pgm;
  pgm.width = HeaderNumber(stream, path);
  pgm.height = HeaderNumber(stream, path);
  const int max_value = HeaderNumber(stream, path);
  if (max_value != 255) {
    throw UserError(path, "has the greatest grey value " + std::to_string(max_value), "save it with 8 bits a pixel");
  }
  if (!std::isspace(stream.get())) {  // Exactly one white space stands before the pixels.
    throw UserError(path, "has a malformed PGM header", "save the picture as binary PGM (P5)");
  }
  const uint64_t begin = static_cast<uint64_t>(stream.tellg());
  stream.seekg(0, std::ios::end);
  const uint64_t present = static_cast<uint64_t>(stream.tellg()) - begin;
  const uint64_t needed = static_cast<uint64_t>(pgm.width) * static_cast<uint64_t>(pgm.height);
  bool is_whole = stream && present >= needed;
  // Editors of text leave a line's end.
  if (is_whole) stream.seekg(static_cast<std::streamoff>(begin + needed));
  for (uint64_t i = needed; is_whole && i < present; ++i) is_whole = std::isspace(stream.get()) != 0;
  if (!is_whole) {
    throw UserError(path,
                    "has " + std::to_string(stream ? present : 0) + " bytes of pixels where " +
                        std::to_string(pgm.width) + " x " + std::to_string(pgm.height) + " need " +
                        std::to_string(needed),
                    "copy or save the picture again");
  }
  stream.seekg(static_cast<std::streamoff>(begin));
  pgm.pixels.resize(needed);
  stream.read(reinterpret_cast<char*>(pgm.pixels.data()), static_cast<std::streamsize>(needed));
  if (!stream) throw UserError(path, "cannot be read to its end", "check the storage");
  return pgm;
}

// `text` as a YAML scalar, quoted where it has to be.
std::string YamlScalar(const std::string& text) {
  YAML::Emitter emitter;
  emitter << text;
  return emitter.c_str();
}

}  // namespace

void WriteMapServer(const std::string& yaml_path, const GridImage& grid) {
  CHECK(grid.width > 0 && grid.height > 0 && std::isfinite(grid.resolution) && grid.resolution > 0.0 &&
        std::isfinite(grid.origin_x) && std::isfinite(grid.origin_y))
      << yaml_path;
  const size_t width = static_cast<size_t>(grid.width);
  const size_t height = static_cast<size_t>(grid.height);
  CHECK_EQ(grid.occupancy.size(), width * height) << yaml_path;
  std::filesystem::path pgm_path(yaml_path);
  if (pgm_path.extension() != ".yaml" && pgm_path.extension() != ".yml") {
    throw UserError(yaml_path, "is no name for a map description", "give a name that ends in .yaml");
  }
  pgm_path.replace_extension(".pgm");

  AtomicFile pgm(pgm_path.string());
  AtomicFile yaml(yaml_path);
  pgm.stream() << "P5\n" << width << ' ' << height << "\n255\n";
  std::vector<char> row_pixels(width);
  for (size_t row = height; row-- > 0;) {
    const uint8_t* const cells = &grid.occupancy[row * width];
    std::transform(cells, cells + width, row_pixels.begin(), [](uint8_t p) { return static_cast<char>(ToPixel(p)); });
    pgm.stream().write(row_pixels.data(), static_cast<std::streamsize>(width));
  }
  yaml.stream() << "image: " << YamlScalar(pgm_path.filename().string())
                << "\nmode: trinary\nresolution: " << ShortestText(grid.resolution) << "\norigin: ["
                << ShortestText(grid.origin_x) << ", " << ShortestText(grid.origin_y)
                << ", 0]\nnegate: 0\noccupied_thresh: " << ShortestText(kOccupiedThreshold)
                << "\nfree_thresh: " << ShortestText(kFreeThreshold) << "\n";
  pgm.Commit();
  yaml.Commit();
}

GridImage ReadMapServer(const std::string& yaml_path) {
  const MapDescription description = ReadDescription(yaml_path);
  // An absolute image path replaces the folder.
  const Pgm pgm = ReadPgm((std::filesystem::path(yaml_path).parent_path() / description.image).string());
  GridImage grid;
  grid.width = pgm.width;
  grid.height = pgm.height;
  grid.resolution = description.resolution;
  grid.origin_x = description.origin_x;
  grid.origin_y = description.origin_y;
  grid.occupancy.reserve(pgm.pixels.size());
  const size_t width = static_cast<size_t>(pgm.width);
  for (size_t row = static_cast<size_t>(pgm.height); row-- > 0;) {
    for (size_t column = 0; column < width; ++column) {
      grid.occupancy.push_back(ToPercent(pgm.pixels[row * width + column], description));
    }
  }
  return grid;
}

}  // namespace arborslam
