#include "core/io/carmen.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/geometry/angles.h"
#include "core/io/input_file.h"
#include "core/io/rising_stamps.h"
#include "core/io/stamp_repair.h"

namespace arborslam {
namespace {

constexpr char kSick[] = "FLASER";
constexpr char kRobotLaser[] = "ROBOTLASER1";
constexpr char kOdometry[] = "ODOM";
constexpr char kSickLayout[] = "FLASER n r_1 ... r_n x y theta odom_x odom_y odom_theta stamp host logger_stamp";
constexpr char kRobotLaserLayout[] =
    "ROBOTLASER1 type start_angle field_of_view resolution maximum_range accuracy remission_mode n r_1 ... r_n m "
    "remission_1 ... remission_m x y theta odom_x odom_y odom_theta tv rv forward_safety side_safety turn_axis stamp "
    "host logger_stamp";
constexpr char kOdometryLayout[] = "ODOM x y theta tv rv acceleration stamp host logger_stamp";

// Lines at the beginning of a file by which it is known to be such a log.
constexpr size_t kLinesToRecognise = 100;
// [m], from here on ranges are error codes of SICK scanners (8183 and more, in centimetres).
constexpr double kSickErrors = 81.82;
// The greatest range is a cut when it occurs this often, and this much more often than all others of the last metre.
constexpr size_t kLeastCuts = 50;
constexpr size_t kCutShare = 10;
// Where so many scans' lines repeat the ODOM message before, their poses are older than the scans.
constexpr double kRepeatedShare = 0.9;
// Beyond this, in [m] or [s], a number is no pose and no stamp.
constexpr double kGreatestCoordinate = 1e9;
constexpr double kGreatestStamp = 1e12;
constexpr double kUsualStep = 0.2;  // [s] from scan to scan, where the stamps do not tell.
// [m, rad], by how much the place of the lidar on the robot may change by rounding.
constexpr double kMountTolerance = 0.01;
// Numbers of readings for which half a circle is usual.
const std::set<size_t> kUsualReadings = {90, 91, 180, 181, 360, 361};

// Which fields of a scan's message hold what.
struct LaserLayout {
  size_t first_range = 0;
  size_t num_ranges = 0;
  size_t pose = 0;  // Of x y theta odom_x odom_y odom_theta.
  size_t stamp = 0;
};

// Thrown for a message that has too few fields: a last line may be so.
class CutShort : public UserError {
 public:
  using UserError::UserError;
};

void ExpectFields(const TextReader& reader, size_t count, const char* layout) {
  if (reader.fields().size() < count) {
    throw CutShort(reader.Place(),
                   reader.fields()[0] + " has " + std::to_string(reader.fields().size()) + " fields instead of " +
                       std::to_string(count),
                   std::string("complete the line to '") + layout + "' or remove it");
  }
  reader.ExpectFields(count, layout);
}

// Field `index` as a number of things, of which the line has at most as many as fields.
size_t Count(const TextReader& reader, size_t index, const char* name, const char* layout) {
  ExpectFields(reader, std::max(reader.fields().size(), index + 1), layout);
  const int count = reader.Integer(index, name);
  if (count < 0) {
    throw UserError(reader.Place(), std::string(name) + " is " + std::to_string(count), "correct or remove the line");
  }
  return static_cast<size_t>(count);
}

LaserLayout LayoutOf(const TextReader& reader) {
  constexpr size_t kPose = 6;
  constexpr size_t kTrailer = 3;
  LaserLayout layout;
  const char* text = kSickLayout;
  if (reader.fields()[0] == kSick) {
    layout.num_ranges = Count(reader, 1, "the number of readings", text);
    layout.first_range = 2;
    layout.pose = layout.first_range + layout.num_ranges;
    layout.stamp = layout.pose + kPose;
  } else {
    constexpr size_t kHeader = 8;  // Tag and seven values.
    constexpr size_t kMotion = 5;  // After the poses.
    text = kRobotLaserLayout;
    layout.num_ranges = Count(reader, kHeader, "the number of readings", text);
    layout.first_range = kHeader + 1;
    const size_t remissions = layout.first_range + layout.num_ranges;
    layout.pose = remissions + 1 + Count(reader, remissions, "the number of remissions", text);
    layout.stamp = layout.pose + kPose + kMotion;
  }
  ExpectFields(reader, layout.stamp + kTrailer, text);
  if (layout.num_ranges == 0) {
    throw UserError(reader.Place(), reader.fields()[0] + " has no readings", "correct or remove the line");
  }
  return layout;
}

double BoundedNumber(const TextReader& reader, size_t index, const char* name, double greatest) {
  const double value = reader.Number(index, name);
  if (!(std::abs(value) <= greatest)) {
    throw UserError(reader.Place(), std::string(name) + " " + Quoted(reader.fields()[index]) + " is out of range",
                    "correct or remove the line");
  }
  return value;
}

SE2 PoseAt(const TextReader& reader, size_t first) {
  const double x = BoundedNumber(reader, first, "x", kGreatestCoordinate);
  const double y = BoundedNumber(reader, first + 1, "y", kGreatestCoordinate);
  return SE2(x, y, BoundedNumber(reader, first + 2, "theta", kGreatestCoordinate));
}

double StampAt(const TextReader& reader, size_t index) { return BoundedNumber(reader, index, "stamp", kGreatestStamp); }

// Infinite where the text says so or that it is not a number; other text is an error.
double RangeAt(const TextReader& reader, size_t index) {
  const std::string& text = reader.fields()[index];
  std::string word = text.substr(text.empty() || (text[0] != '+' && text[0] != '-') ? 0 : 1);
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool is_negative = !text.empty() && text[0] == '-';
  if (word == "nan" || ((word == "inf" || word == "infinity") && !is_negative)) {
    return std::numeric_limits<double>::infinity();
  }
  return reader.Number(index, "range");
}

float ToFloat(double range) {
  return range > std::numeric_limits<float>::max() ? std::numeric_limits<float>::infinity() : static_cast<float>(range);
}

// How often the greatest ranges of a log occur.
class RangeCensus {
 public:
  void Add(double range) {
    if (!(range < kSickErrors) || range < greatest_ - kWidth) return;
    ++counts_[range];
    if (range <= greatest_) return;
    greatest_ = range;
    counts_.erase(counts_.begin(), counts_.lower_bound(greatest_ - kWidth));
  }

  // The range at which the log's driver cut; nothing if it did not.
  std::optional<double> Cut() const {
    if (counts_.empty()) return std::nullopt;
    size_t others = 0;
    for (auto entry = counts_.begin(); entry != std::prev(counts_.end()); ++entry) others += entry->second;
    const auto& [range, count] = *counts_.rbegin();
    if (count < kLeastCuts || count < kCutShare * others) return std::nullopt;
    return range;
  }

 private:
  static constexpr double kWidth = 1.0;  // [m]

  double greatest_ = 0.0;
  std::map<double, size_t> counts_;  // Of the ranges of the last `kWidth`.
};

// What the scans' lines of one kind say, but for the ranges.
struct ScanIndex {
  std::vector<double> stamps;
  std::vector<SE2> lidar;  // As on the line.
  std::vector<SE2> robot;
  std::vector<size_t> num_odometry;  // ODOM messages before the line.
  size_t num_repeated = 0;           // Lines whose robot is where the last of these was.
  std::set<size_t> num_ranges;
  size_t num_negative = 0;  // Ranges.
};

struct OdometryMessage {
  double stamp;
  SE2 pose;
};

// A log without its ranges.
struct LogIndex {
  std::map<std::string, ScanIndex> scans;  // By the message's tag.
  std::vector<OdometryMessage> odometry;
  RangeCensus ranges;  // Of FLASER.
  bool is_cut_short = false;
};

void AddMessage(const TextReader& reader, LogIndex* index) {
  const std::string& tag = reader.fields()[0];
  if (tag == kOdometry) {
    ExpectFields(reader, 10, kOdometryLayout);
    index->odometry.push_back({StampAt(reader, 7), PoseAt(reader, 1)});
  }
  if (tag != kSick && tag != kRobotLaser) return;
  const LaserLayout layout = LayoutOf(reader);
  if (tag == kRobotLaser) {
    for (size_t i = 1; i < 6; ++i) BoundedNumber(reader, i, "a value of the lidar", kGreatestCoordinate);
  }
  size_t num_negative = 0;
  for (size_t i = 0; i < layout.num_ranges; ++i) {
    const double range = RangeAt(reader, layout.first_range + i);
    num_negative += range < 0.0 ? 1 : 0;
    if (tag == kSick) index->ranges.Add(range);
  }
  const double stamp = StampAt(reader, layout.stamp);
  const SE2 lidar = PoseAt(reader, layout.pose);
  const SE2 robot = PoseAt(reader, layout.pose + 3);
  ScanIndex& scans = index->scans[tag];
  scans.num_negative += num_negative;
  scans.stamps.push_back(stamp);
  scans.lidar.push_back(lidar);
  scans.robot.push_back(robot);
  scans.num_odometry.push_back(index->odometry.size());
  scans.num_repeated += !index->odometry.empty() && robot.IsApprox(index->odometry.back().pose) ? 1 : 0;
  scans.num_ranges.insert(layout.num_ranges);
}

LogIndex ReadIndex(const std::string& path) {
  LogIndex index;
  TextReader reader(path);
  std::optional<CutShort> cut_short;
  while (reader.Next()) {
    if (cut_short) throw UserError(*cut_short);
    try {
      AddMessage(reader, &index);
    } catch (const CutShort& error) {
      cut_short = error;
    }
  }
  index.is_cut_short = cut_short.has_value();
  return index;
}

bool Changes(const std::vector<SE2>& poses) {
  return std::any_of(poses.begin(), poses.end(), [&](const SE2& pose) { return !pose.IsApprox(poses.front()); });
}

// Whether the lidar stays where it is on the robot.
bool IsMountFixed(const ScanIndex& scans) {
  const SE2 T_robot_lidar = scans.robot.front().Inverse() * scans.lidar.front();
  for (size_t i = 1; i < scans.lidar.size(); ++i) {
    if (!(scans.robot[i].Inverse() * scans.lidar[i]).IsApprox(T_robot_lidar, kMountTolerance)) return false;
  }
  return true;
}

// The robot's poses at `stamps` [s, rising] between the ODOM messages before and after each scan's line; that one's
// pose where there is none on the other side.
std::vector<SE2> PosesBetween(const ScanIndex& scans, const std::vector<double>& stamps,
                              const std::vector<OdometryMessage>& messages) {
  std::vector<double> message_stamps;
  message_stamps.reserve(messages.size());
  for (const OdometryMessage& message : messages) message_stamps.push_back(message.stamp);
  message_stamps = MakeRising(std::move(message_stamps)).stamps;
  std::vector<SE2> poses;
  poses.reserve(stamps.size());
  for (size_t scan = 0; scan < stamps.size(); ++scan) {
    const size_t after = scans.num_odometry[scan];
    if (after == 0 || after == messages.size()) {
      poses.push_back(messages[after == 0 ? 0 : after - 1].pose);
      continue;
    }
    const double gap = message_stamps[after] - message_stamps[after - 1];
    const double share = gap > 0.0 ? (stamps[scan] - message_stamps[after - 1]) / gap : 0.0;
    poses.push_back(Interpolate(messages[after - 1].pose, messages[after].pose, std::clamp(share, 0.0, 1.0)));
  }
  return poses;
}

// The lidar's poses by the wheels, one per scan, or none.
std::vector<SE2> OdometryOf(const ScanIndex& scans, const std::vector<double>& stamps,
                            const std::vector<OdometryMessage>& messages, std::vector<std::string>* notices) {
  if (Changes(scans.robot) && !IsMountFixed(scans)) {
    notices->push_back(
        "The lidar's place on the robot changes from scan to scan, as in corrected logs; the robot's own odometry is "
        "used.");
    return scans.robot;
  }
  const bool has_messages = std::any_of(messages.begin(), messages.end(), [&](const OdometryMessage& message) {
    return !message.pose.IsApprox(messages.front().pose);
  });
  const bool has_poses = Changes(scans.lidar);
  const bool repeats = static_cast<double>(scans.num_repeated) >= kRepeatedShare * static_cast<double>(stamps.size());
  if (has_messages && (repeats || !has_poses)) {
    const SE2 T_robot_lidar = scans.robot.front().Inverse() * scans.lidar.front();
    std::vector<SE2> poses = PosesBetween(scans, stamps, messages);
    for (SE2& pose : poses) pose = pose * T_robot_lidar;
    return poses;
  }
  if (has_poses) return scans.lidar;
  notices->push_back("The log has no wheel odometry; the scans alone tell the motion.");
  return {};
}

}  // namespace

bool CarmenScanSource::Recognises(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".clf" || extension == ".carmen") return true;
  try {
    TextReader reader(path);
    for (size_t i = 0; i < kLinesToRecognise && reader.Next(); ++i) {
      const std::string& tag = reader.fields()[0];
      for (const char* known : {kSick, kRobotLaser, kOdometry, "PARAM", "SYNC"}) {
        if (tag == known) return true;
      }
    }
  } catch (const UserError&) {
    // No text.
  }
  return false;
}

CarmenScanSource::CarmenScanSource(const std::string& path) : reader_(path) {
  LogIndex index = ReadIndex(path);
  if (index.scans.empty()) {
    throw UserError(path, "holds no scans", "give a CARMEN log with FLASER or ROBOTLASER1 messages");
  }
  tag_ = kSick;
  const size_t num_sick = index.scans[kSick].stamps.size();
  const size_t num_robot = index.scans[kRobotLaser].stamps.size();
  if (num_robot > num_sick) tag_ = kRobotLaser;
  if (num_sick > 0 && num_robot > 0) {
    notices_.push_back("The log has its scans as FLASER and as ROBOTLASER1; " + tag_ + " is read.");
  }
  ScanIndex& scans = index.scans[tag_];
  if (index.is_cut_short) notices_.push_back("The last line is cut short; it is left out.");
  if (scans.num_negative > 0) {
    notices_.push_back(std::to_string(scans.num_negative) + " ranges are negative; nothing came back there.");
  }
  if (tag_ == kSick) {
    for (const size_t count : scans.num_ranges) {
      if (kUsualReadings.count(count) > 0) continue;
      notices_.push_back("Scans of " + std::to_string(count) + " readings are taken to cover half a circle.");
    }
  }
  const double cut = index.ranges.Cut().value_or(kSickErrors);
  no_return_ = static_cast<float>(tag_ == kSick ? cut : std::numeric_limits<double>::infinity());

  RepairedStamps repaired = RepairStamps(std::move(scans.stamps), kUsualStep);
  stamps_ = std::move(repaired.seconds);
  notices_.insert(notices_.end(), repaired.notices.begin(), repaired.notices.end());
  odometry_ = OdometryOf(scans, stamps_, index.odometry, &notices_);
}

std::optional<Scan> CarmenScanSource::Next() {
  if (next_ == stamps_.size()) return std::nullopt;
  do {
    if (!reader_.Next()) return std::nullopt;  // Someone has cut the file since.
  } while (reader_.fields()[0] != tag_);
  const LaserLayout layout = LayoutOf(reader_);
  LaserScan scan;
  scan.stamp = stamps_[next_];
  if (!odometry_.empty()) scan.odometry = odometry_[next_];
  ++next_;
  const auto count = static_cast<double>(layout.num_ranges);
  auto no_return = no_return_;
  if (tag_ == kSick) {
    scan.bearing_min = -0.5 * kPi;
    scan.bearing_increment = kPi / (layout.num_ranges % 2 == 0 ? count : std::max(1.0, count - 1.0));
  } else {
    scan.bearing_min = reader_.Number(2, "start angle");
    scan.bearing_increment = reader_.Number(4, "resolution");
    const double maximum = reader_.Number(5, "maximum range");
    if (maximum > 0.0) no_return = ToFloat(maximum);
  }
  scan.ranges.reserve(layout.num_ranges);
  for (size_t i = 0; i < layout.num_ranges; ++i) {
    const float range = ToFloat(RangeAt(reader_, layout.first_range + i));
    scan.ranges.push_back(range >= 0.0f && range < no_return ? range : std::numeric_limits<float>::infinity());
  }
  return scan;
}

}  // namespace arborslam
