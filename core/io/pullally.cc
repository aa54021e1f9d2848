#include "core/io/pullally.h"

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/geometry/angles.h"
#include "core/io/stamp_repair.h"

namespace arborslam {
namespace {

constexpr char kScanKey[] = "scan0";
constexpr char kTimeKey[] = "time";
constexpr double kUsualStep = 1.0;  // [s] from scan to scan, where the stamps do not tell.

// The conversion of a double that no float can hold is undefined.
float ToFloat(double range) {
  return range > std::numeric_limits<float>::max() ? std::numeric_limits<float>::infinity() : static_cast<float>(range);
}

}  // namespace

std::optional<std::vector<double>> ReadPullallyStamps(const NpzFile& file, size_t count) {
  if (!file.Has(kTimeKey)) return std::nullopt;
  NpyArray time = file.Read(kTimeKey);
  const bool is_column = time.shape.size() == 1 || (time.shape.size() == 2 && time.shape[1] == 1);
  if (!is_column || time.shape[0] != count) {
    throw UserError(file.Place(kTimeKey), "has the shape " + time.ShapeText(),
                    "give one stamp for each of the " + std::to_string(count) + " records");
  }
  return std::move(time.values);
}

PullallyScanSource::PullallyScanSource(const std::string& path) {
  const NpzFile file(path);
  const NpyArray scans = file.Read(kScanKey);
  if (scans.shape.size() != 2 || scans.shape[0] == 0 || scans.shape[1] < 2) {
    throw UserError(file.Place(kScanKey), "has the shape " + scans.ShapeText(),
                    "give ranges as (scans, beams), at least one scan of two beams");
  }
  const size_t num_scans = scans.shape[0];
  num_beams_ = scans.shape[1];

  if (std::optional<std::vector<double>> stamps = ReadPullallyStamps(file, num_scans)) {
    RepairedStamps repaired = RepairStamps(std::move(*stamps), kUsualStep);
    stamps_ = std::move(repaired.seconds);
    notices_ = std::move(repaired.notices);
  } else {
    for (size_t i = 0; i < num_scans; ++i) stamps_.push_back(kUsualStep * static_cast<double>(i));
    notices_.push_back("The recording has no array 'time'; its scans are stamped one second apart.");
  }

  size_t num_invalid = 0;
  ranges_.reserve(scans.values.size());
  for (const double range : scans.values) {
    const bool is_valid = range >= 0.0;  // False for NaN too.
    num_invalid += is_valid ? 0 : 1;
    ranges_.push_back(is_valid ? ToFloat(range) : std::numeric_limits<float>::quiet_NaN());
  }
  if (num_invalid > 0) {
    notices_.push_back(std::to_string(num_invalid) + " of the " + std::to_string(ranges_.size()) +
                       " ranges are negative or not a number; they count as beams without return.");
  }
}

std::optional<Scan> PullallyScanSource::Next() {
  if (next_ == stamps_.size()) return std::nullopt;
  LaserScan scan;
  scan.stamp = stamps_[next_];
  scan.bearing_min = -kPi;
  scan.bearing_increment = 2.0 * kPi / static_cast<double>(num_beams_ + 1);
  const auto begin = ranges_.begin() + static_cast<std::ptrdiff_t>(next_ * num_beams_);
  scan.ranges.assign(begin, begin + static_cast<std::ptrdiff_t>(num_beams_));
  ++next_;
  return scan;
}

}  // namespace arborslam
