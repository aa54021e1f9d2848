#include "core/io/point_cloud_file.h"

#include <glog/logging.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/cloud_layout.h"
#include "core/io/input_file.h"
#include "core/io/sweep_points.h"

namespace arborslam {
namespace {

using Encoding = CloudLayout::Encoding;

constexpr uint64_t kMaxFileSize = uint64_t{1} << 30;  // [bytes]
constexpr const char* kTimeFields[] = {"time", "t", "timestamp", "time_stamp", "offset_time"};

std::string ReadWholeFile(const std::string& path) {
  std::ifstream stream = OpenInputFile(path);
  stream.seekg(0, std::ios::end);
  const auto size = static_cast<uint64_t>(stream.tellg());
  if (size > kMaxFileSize) {
    throw UserError(path, "is " + std::to_string(size) + " bytes long, too long for one sweep",
                    "check that it is one revolution of a lidar");
  }
  stream.seekg(0);
  std::string contents(size, '\0');
  if (!stream.read(contents.data(), static_cast<std::streamsize>(size))) {
    throw UserError(path, "cannot be read to its end", "check the storage");
  }
  return contents;
}

// The fields that make a sweep.
struct SweepFields {
  std::array<const CloudField*, 3> xyz = {};
  const CloudField* time = nullptr;  // Or null.
};

SweepFields FindSweepFields(const std::string& path, const CloudLayout& layout) {
  SweepFields fields;
  constexpr const char* kNames[] = {"x", "y", "z"};
  for (size_t axis = 0; axis < 3; ++axis) {
    const CloudField* field = layout.Find(kNames[axis]);
    if (field == nullptr) {
      std::string names;
      for (const CloudField& other : layout.fields) names += (names.empty() ? "" : " ") + other.name;
      throw UserError(path, std::string("has no field '") + kNames[axis] + "' (it has " + Quoted(names) + ")",
                      "give points with the fields x, y, z");
    }
    if (field->type != 'F' || field->count != 1) {
      throw UserError(path, std::string("has a field '") + kNames[axis] + "' that is no single floating-point number",
                      "give coordinates in metres as float or double");
    }
    fields.xyz[axis] = field;
  }
  for (const char* name : kTimeFields) {
    const CloudField* field = layout.Find(name);
    if (field == nullptr || field->count != 1) continue;
    fields.time = field;
    break;
  }
  return fields;
}

// A double that no float can hold becomes an infinity, which is dropped: its conversion is undefined.
float ToFloat(double value) {
  if (std::abs(value) > std::numeric_limits<float>::max()) return std::numeric_limits<float>::infinity();
  return static_cast<float>(value);
}

void AppendPointWithTime(const std::array<double, 3>& xyz, double time, bool has_time, PointCloudFile* file) {
  if (!AppendPoint(ToFloat(xyz[0]), ToFloat(xyz[1]), ToFloat(xyz[2]), &file->sweep)) return;
  if (has_time) file->raw_times.push_back(time);
}

uint8_t PclType(const CloudField& field) {
  using Type = pcl::PCLPointField;
  switch (field.size) {
    case 1:
      return field.type == 'I' ? Type::INT8 : Type::UINT8;
    case 2:
      return field.type == 'I' ? Type::INT16 : Type::UINT16;
    case 4:
      return field.type == 'F' ? Type::FLOAT32 : field.type == 'I' ? Type::INT32 : Type::UINT32;
    default:
      return field.type == 'F' ? Type::FLOAT64 : field.type == 'I' ? Type::INT64 : Type::UINT64;
  }
}

template <typename T>
double ValueAs(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<double>(value);
}

double Value(const CloudField& field, const uint8_t* point) {
  const uint8_t* bytes = point + field.offset;
  switch (field.size) {
    case 1:
      return field.type == 'I' ? ValueAs<int8_t>(bytes) : ValueAs<uint8_t>(bytes);
    case 2:
      return field.type == 'I' ? ValueAs<int16_t>(bytes) : ValueAs<uint16_t>(bytes);
    case 4:
      if (field.type == 'F') return ValueAs<float>(bytes);
      return field.type == 'I' ? ValueAs<int32_t>(bytes) : ValueAs<uint32_t>(bytes);
    default:
      if (field.type == 'F') return ValueAs<double>(bytes);
      return field.type == 'I' ? ValueAs<int64_t>(bytes) : ValueAs<uint64_t>(bytes);
  }
}

void SwapBytes(const CloudLayout& layout, std::string* body) {
  for (size_t begin = 0; begin + layout.point_size <= body->size(); begin += layout.point_size) {
    for (const CloudField& field : layout.fields) {
      char* value = body->data() + begin + field.offset;
      for (size_t i = 0; i < field.count; ++i, value += field.size) std::reverse(value, value + field.size);
    }
  }
}

// The points of a binary body through PCL, as an array of structures laid out as `layout` says. The vertices of a
// binary PLY file are laid out as the points of a binary PCD file, and are read as such: PCL's reader of PLY reads from
// files only and believes what it is told about widths, colours and lists.
pcl::PCLPointCloud2 UnpackWithPcl(const std::string& path, const CloudLayout& layout, std::string_view body) {
  // PCL writes to the console of whoever uses it.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  pcl::PCLPointCloud2 cloud;
  for (const CloudField& field : layout.fields) {
    cloud.fields.emplace_back();
    cloud.fields.back().name = field.name;
    cloud.fields.back().offset = static_cast<pcl::uindex_t>(field.offset);
    cloud.fields.back().count = static_cast<pcl::uindex_t>(field.count);
    cloud.fields.back().datatype = PclType(field);
  }
  cloud.width = static_cast<pcl::uindex_t>(layout.num_points);
  cloud.height = 1;
  cloud.point_step = static_cast<pcl::uindex_t>(layout.point_size);
  cloud.row_step = cloud.width * cloud.point_step;
  const size_t size = layout.num_points * layout.point_size;
  cloud.data.resize(size);
  const bool is_compressed = layout.encoding == Encoding::kCompressedColumns;
  const auto* data = reinterpret_cast<const unsigned char*>(body.data());
  std::string reason;
  try {
    pcl::PCDReader reader;
    if (reader.readBodyBinary(data, cloud, pcl::PCDReader::PCD_V7, is_compressed, 0) == 0) {
      CHECK_EQ(cloud.data.size(), size);
      return cloud;
    }
  } catch (const std::exception& error) {
    reason = std::string(" (") + error.what() + ")";
  }
  throw UserError(path, "has points that cannot be unpacked" + reason, "check that it was copied completely");
}

void ReadBinaryPoints(const std::string& path, const CloudLayout& layout, const SweepFields& fields,
                      std::string_view body, PointCloudFile* file) {
  std::string swapped;
  if (layout.encoding == Encoding::kBigEndian) {
    swapped = body.substr(0, layout.num_points * layout.point_size);
    SwapBytes(layout, &swapped);
    body = swapped;
  }
  const pcl::PCLPointCloud2 cloud = UnpackWithPcl(path, layout, body);
  for (size_t i = 0; i < layout.num_points; ++i) {
    const uint8_t* point = cloud.data.data() + i * layout.point_size;
    const double time = fields.time != nullptr ? Value(*fields.time, point) : 0.0;
    AppendPointWithTime({Value(*fields.xyz[0], point), Value(*fields.xyz[1], point), Value(*fields.xyz[2], point)},
                        time, fields.time != nullptr, file);
  }
}

// The lines of a text body. PCL's reader of text takes nonsense for 0, goes by the locale, and takes several times as
// long.
class TextBody {
 public:
  TextBody(const std::string& path, std::string_view body, size_t num_lines_before)
      : path_(path), rest_(body), line_(num_lines_before) {}

  // Goes to the next line that is not blank; false at the end.
  bool Next() {
    while (!rest_.empty()) {
      const size_t end = std::min(rest_.find('\n'), rest_.size());
      values_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
      if (values_.find_first_not_of(kSpace) != std::string_view::npos) return true;
    }
    return false;
  }

  // Splits the line into `count` words.
  void Split(size_t count, std::vector<std::string_view>* words) const {
    words->clear();
    size_t num_words = 0;
    for (size_t begin = values_.find_first_not_of(kSpace); begin != std::string_view::npos; ++num_words) {
      const size_t end = std::min(values_.find_first_of(kSpace, begin), values_.size());
      if (num_words < count) words->push_back(values_.substr(begin, end - begin));
      begin = values_.find_first_not_of(kSpace, end);
    }
    if (num_words != count) {
      Fail("has " + std::to_string(num_words) + " values instead of " + std::to_string(count));
    }
  }

  // A number; NaN when no double can hold it.
  double Number(std::string_view word) const {
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0.0;
    const std::from_chars_result result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool is_whole = result.ptr == digits.data() + digits.size();
    if (is_whole && result.ec == std::errc()) return value;
    if (is_whole && result.ec == std::errc::result_out_of_range) return std::numeric_limits<double>::quiet_NaN();
    Fail(Quoted(std::string(word)) + " is not a number");
  }

 private:
  static constexpr std::string_view kSpace = " \t\r\v\f";

  [[noreturn]] void Fail(const std::string& problem) const {
    throw UserError(path_ + ", line " + std::to_string(line_), problem, "correct the line, or copy the file again");
  }

  const std::string& path_;
  std::string_view rest_;
  size_t line_;
  std::string_view values_;
};

void ReadTextPoints(const std::string& path, const CloudLayout& layout, const SweepFields& fields,
                    std::string_view body, PointCloudFile* file) {
  TextBody text(path, body, layout.lines_before_body);
  for (size_t i = 0; i < layout.lines_to_skip && text.Next(); ++i) continue;
  size_t num_points = 0;
  std::vector<std::string_view> words;
  while ((num_points < layout.num_points || !layout.has_more) && text.Next()) {
    if (++num_points > layout.num_points) continue;
    text.Split(layout.point_size, &words);
    std::array<double, 3> xyz;
    for (size_t axis = 0; axis < 3; ++axis) xyz[axis] = text.Number(words[fields.xyz[axis]->offset]);
    const double time = fields.time != nullptr ? text.Number(words[fields.time->offset]) : 0.0;
    AppendPointWithTime(xyz, time, fields.time != nullptr, file);
  }
  if (num_points != layout.num_points) {
    throw UserError(path,
                    "should have " + std::to_string(layout.num_points) + " points by its header but has " +
                        std::to_string(num_points),
                    "check that it was copied completely");
  }
}

// Drops the points without a finite time and those whose time is not of the sweep, or all times when most are not
// finite.
void KeepPlausibleTimes(PointCloudFile* file) {
  std::vector<double>& times = file->raw_times;
  std::vector<double> finite;
  std::copy_if(times.begin(), times.end(), std::back_inserter(finite), [](double time) { return std::isfinite(time); });
  if (2 * finite.size() < times.size()) {
    times.clear();
    return;
  }
  // A few times that are not of the sweep decide nothing: all lie within what nine in ten of them span, or near it.
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  if (!finite.empty()) {
    const auto quantile = [&finite](double share) {
      const auto nth = finite.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(finite.size() - 1));
      std::nth_element(finite.begin(), nth, finite.end());
      return *nth;
    };
    const double low = quantile(0.05);
    const double high = quantile(0.95);
    if (high > low) {
      least = low - (high - low);
      greatest = high + (high - low);
    }
  }
  const auto is_kept = [&](double time) { return time >= least && time <= greatest && std::isfinite(time); };
  const auto num_kept = static_cast<size_t>(std::count_if(times.begin(), times.end(), is_kept));
  if (num_kept == times.size()) return;
  std::vector<Eigen::Vector3f>& points = file->sweep.points;
  file->sweep.num_dropped += times.size() - num_kept;
  size_t kept = 0;
  for (size_t i = 0; i < times.size(); ++i) {
    if (!is_kept(times[i])) continue;
    points[kept] = points[i];
    times[kept] = times[i];
    ++kept;
  }
  points.resize(kept);
  times.resize(kept);
}

}  // namespace

PointCloudFile ReadPointCloudFile(const std::string& path) {
  const std::string contents = ReadWholeFile(path);
  const CloudLayout layout = ParseCloudHeader(path, contents);
  const SweepFields fields = FindSweepFields(path, layout);
  PointCloudFile file;
  if (fields.time != nullptr) file.time_field = fields.time->name;
  file.sweep.points.reserve(layout.num_points);
  if (fields.time != nullptr) file.raw_times.reserve(layout.num_points);
  const std::string_view body = std::string_view(contents).substr(layout.body);
  if (layout.encoding == Encoding::kText) {
    ReadTextPoints(path, layout, fields, body, &file);
  } else if (layout.num_points > 0) {
    ReadBinaryPoints(path, layout, fields, body, &file);
  }
  KeepPlausibleTimes(&file);
  return file;
}

void WritePcd(const std::string& path, const LidarSweep& sweep) {
  const bool has_times = !sweep.times.empty();
  CHECK(!has_times || sweep.times.size() == sweep.points.size());
  AtomicFile file(path);
  const std::string count = std::to_string(sweep.points.size());
  file.stream() << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
                << (has_times ? "FIELDS x y z time\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
                              : "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n")
                << "WIDTH " << count << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << count << "\nDATA binary\n";
  for (size_t i = 0; i < sweep.points.size(); ++i) {
    const Eigen::Vector3f& point = sweep.points[i];
    const float record[] = {point.x(), point.y(), point.z(), has_times ? sweep.times[i] : 0.0f};
    file.stream().write(reinterpret_cast<const char*>(record), static_cast<std::streamsize>(has_times ? 16 : 12));
  }
  file.Commit();
}

}  // namespace arborslam
