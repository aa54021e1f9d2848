#include "core/io/sweep_folder_options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/io/bin_layout.h"

namespace arborslam {

std::string SweepFolderOptions::Validate() const {
  if (stamp != "start" && stamp != "middle" && stamp != "end") {
    return Violation("stamp", stamp, "be start, middle or end");
  }
  if (!(sweep_duration >= 0.0 && sweep_duration <= 10.0)) {
    return Violation("sweep_duration", sweep_duration, "lie in [0, 10] s (0: found out)");
  }
  if (!T_base_lidar.empty() && !ParsePose(T_base_lidar)) {
    return Violation("T_base_lidar", T_base_lidar, "be six numbers, x y z roll pitch yaw in m and deg, or empty");
  }
  if (frame != "lidar" && frame != "base") return Violation("frame", frame, "be lidar or base");
  if (frame == "base" && T_base_lidar.empty()) {
    return Violation("frame", frame, "be lidar unless T_base_lidar says where in base the lidar is");
  }
  if (BinLayout parsed; layout != "auto" && !ParseBinLayout(layout, &parsed)) {
    return Violation("layout", layout, "be auto or like '5 x float32', '3 x float64, big-endian'");
  }
  return "";
}

std::optional<Eigen::Isometry3d> ParsePose(const std::string& text) {
  std::string numbers = text;
  std::replace(numbers.begin(), numbers.end(), ',', ' ');
  std::istringstream stream(numbers);
  stream.imbue(std::locale::classic());
  std::array<double, 6> values{};
  for (double& value : values) {
    if (!(stream >> value) || !std::isfinite(value)) return std::nullopt;
  }
  if (!(stream >> std::ws).eof()) return std::nullopt;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << values[0], values[1], values[2];
  pose.linear() = (Eigen::AngleAxisd(DegToRad(values[5]), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(DegToRad(values[4]), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(DegToRad(values[3]), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

}  // namespace arborslam
