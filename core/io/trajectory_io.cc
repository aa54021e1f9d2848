#include "core/io/trajectory_io.h"

#include <glog/logging.h>

#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <ostream>
#include <vector>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/input_file.h"
#include "core/io/npz.h"
#include "core/io/pullally.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr char kRunKey[] = "gnss_rotated_c";
constexpr char kSiteKey[] = "gnss_data";
constexpr char kTumLayout[] = "stamp x y z qx qy qz qw";
constexpr double kNormTolerance = 0.01;

// Appends `pose` unless its stamp is not later than the last one's.
void AppendInOrder(const StampedPose3& pose, const std::string& place, Trajectory3* trajectory) {
  if (!trajectory->poses.empty() && !(pose.stamp > trajectory->poses.back().stamp)) {
    throw UserError(place,
                    "has the stamp " + ShortestText(pose.stamp) + ", not later than " +
                        ShortestText(trajectory->poses.back().stamp) + " before it",
                    "sort the poses by time, one to a stamp");
  }
  trajectory->poses.push_back(pose);
}

Trajectory3 ReadTum(const std::string& path) {
  TextReader reader(path);
  Trajectory3 trajectory;
  while (reader.Next()) {
    reader.ExpectFields(8, kTumLayout);
    constexpr std::array<const char*, 8> kNames = {"stamp", "x", "y", "z", "qx", "qy", "qz", "qw"};
    std::array<double, 8> values;
    for (size_t i = 0; i < values.size(); ++i) values[i] = reader.Number(i, kNames[i]);
    StampedPose3 pose;
    pose.stamp = values[0];
    pose.position = {values[1], values[2], values[3]};
    pose.orientation = Eigen::Quaterniond(values[7], values[4], values[5], values[6]);
    const double norm = pose.orientation.norm();
    if (!(std::abs(norm - 1.0) <= kNormTolerance)) {
      throw UserError(reader.Place(), "has a quaternion of norm " + ShortestText(norm),
                      "give unit quaternions in the order qx qy qz qw");
    }
    pose.orientation.normalize();
    AppendInOrder(pose, reader.Place(), &trajectory);
  }
  if (trajectory.poses.empty()) {
    throw UserError(path, "holds no poses", std::string("write one a line as '") + kTumLayout + "'");
  }
  return trajectory;
}

Trajectory3 ReadPullallyReference(const std::string& path, ReferenceFrame frame) {
  const NpzFile file(path);
  const std::string key = frame == ReferenceFrame::kOfRun ? kRunKey : kSiteKey;
  const NpyArray positions = file.Read(key);
  // Of the site there is the altitude, too.
  const bool has_columns = positions.shape.size() == 2 &&
                           (positions.shape[1] == 2 || (frame == ReferenceFrame::kOfSite && positions.shape[1] > 2));
  if (!has_columns || positions.shape[0] == 0) {
    throw UserError(file.Place(key), "has the shape " + positions.ShapeText(),
                    "give positions as (records, 2), at least one");
  }
  const size_t num_columns = positions.shape[1];
  const size_t count = positions.shape[0];
  const std::optional<std::vector<double>> stamps = ReadPullallyStamps(file, count);
  Trajectory3 trajectory;
  trajectory.has_orientation = false;
  for (size_t i = 0; i < count; ++i) {
    const std::string record = ", record " + std::to_string(i);
    StampedPose3 pose;
    pose.stamp = stamps ? (*stamps)[i] : static_cast<double>(i);
    pose.position = {positions.values[num_columns * i], positions.values[num_columns * i + 1], 0.0};
    if (!pose.position.allFinite()) {
      throw UserError(file.Place(key) + record, "is not finite", "leave out records without a position");
    }
    AppendInOrder(pose, file.Place("time") + record, &trajectory);
  }
  return trajectory;
}

}  // namespace

Trajectory3 ReadTrajectory(const std::string& path, ReferenceFrame frame) {
  return HasZipMagic(path) ? ReadPullallyReference(path, frame) : ReadTum(path);
}

void WriteTum(const std::string& path, const Trajectory3& trajectory, const std::string& stamp) {
  AtomicFile file(path);
  std::ostream& stream = file.stream();
  stream << "# stamp = " << stamp << ", T_map_base as x y z [m] and unit quaternion\n# " << kTumLayout << "\n"
         << std::fixed << std::setprecision(9);
  for (const StampedPose3& pose : trajectory.poses) {
    CHECK(std::isfinite(pose.stamp) && pose.position.allFinite() && pose.orientation.coeffs().allFinite())
        << "pose stamped " << pose.stamp << " of " << path;
    stream << pose.stamp;
    for (const double value : pose.position) stream << ' ' << value;
    for (const double value : pose.orientation.coeffs()) stream << ' ' << value;  // Eigen's order is x y z w.
    stream << '\n';
  }
  file.Commit();
}

void WriteTum(const std::string& path, const Trajectory& trajectory, const std::string& stamp) {
  WriteTum(path, ToTrajectory3(trajectory), stamp);
}

}  // namespace arborslam
