#include "frontend/mounting/levelled_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>
#include <variant>

#include "core/error.h"
#include "core/geometry/angles.h"
#include "frontend/mounting/mounting.h"

namespace arborslam {
namespace {

constexpr size_t kMaxAhead = 20;  // Scans.
constexpr size_t kEvery = 2;      // Of them is examined.
constexpr size_t kMinPoints = 100;
constexpr float kAssumedHeight = 1.0f;  // [m], of a lidar over the ground.
constexpr float kMaxContradiction = static_cast<float>(DegToRad(30.0));

std::string MetresText(float value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.2f m", static_cast<double>(value));
  return text.data();
}

std::string DegreesText(float radians) { return std::to_string(std::lround(RadToDeg(radians))) + " deg"; }

}  // namespace

LevelledSource::LevelledSource(std::unique_ptr<ScanSource> source, const SweepFolderOptions& options)
    : source_(std::move(source)), notices_(source_->Notices()) {
  std::vector<LidarSweep> sweeps = ReadAhead();
  if (options.T_base_lidar.empty()) {
    FindMounting(std::move(sweeps));
  } else {
    TakeMounting(options, std::move(sweeps));
  }
}

std::vector<LidarSweep> LevelledSource::ReadAhead() {
  std::vector<LidarSweep> sweeps;
  try {
    while (ahead_.size() < kMaxAhead) {
      std::optional<Scan> scan = source_->Next();
      if (!scan) break;
      const LidarSweep* sweep = std::get_if<LidarSweep>(&*scan);
      const bool is_planar = sweep == nullptr;
      if (!is_planar && ahead_.size() % kEvery == 0 && sweep->points.size() >= kMinPoints) sweeps.push_back(*sweep);
      ahead_.push_back(std::move(*scan));
      if (is_planar) return {};
    }
  } catch (...) {
    error_ = std::current_exception();
  }
  return sweeps;
}

void LevelledSource::FindMounting(std::vector<LidarSweep> sweeps) {
  if (sweeps.empty()) return;
  const MountingEstimate mounting = EstimateMounting(sweeps);
  if (!mounting.ok) {
    notices_.push_back("No ground was found in most of the first " + std::to_string(ahead_.size()) +
                       " sweeps: the points are assumed to be in the frame of an upright lidar, x ahead, y left, z up; "
                       "if they are not, option input.T_base_lidar states the mounting.");
    return;
  }
  std::string text;
  if (!IsUsualTilt(mounting.up)) {
    is_levelling_ = true;
    const Eigen::Vector3f up = SnappedToAxis(mounting.up);
    rotation_ = UprightRotation(up);
    spin_axis_ = rotation_ * Eigen::Vector3f::UnitZ();
    text = "The lidar is mounted " + MountingText(up) +
           ", as the ground shows: sweeps are turned upright, x in the heading of the lidar's " +
           (KeepsHeadingOfX(up) ? "x axis. " : "z axis (its x axis is vertical). ");
  }
  // Points that were turned upright already, by whoever recorded them, may have any origin.
  std::optional<float> beam_height;
  if (!is_levelling_) beam_height = BeamOriginHeight(sweeps, mounting.height);
  const bool is_found = beam_height.has_value();
  if (!is_found && !IsUsualHeight(mounting.height)) beam_height = kAssumedHeight - mounting.height;
  if (beam_height) {
    is_levelling_ = true;
    translation_.z() = -*beam_height;
    text += "The origin of the points is " + MetresText(std::abs(mounting.height)) +
            (mounting.height < 0.0f ? " below" : " above") + " the ground, " +
            (is_found ? "and no beam comes from there, as" : "as") +
            " in a frame of the robot (base_link): sweeps are moved to a lidar " + (is_found ? "found " : "assumed ") +
            MetresText(mounting.height + *beam_height) + " above the ground. ";
  }
  if (!is_levelling_) return;
  notices_.push_back(text + "Poses are those of this upright frame; option input.T_base_lidar states it exactly.");
}

void LevelledSource::TakeMounting(const SweepFolderOptions& options, std::vector<LidarSweep> sweeps) {
  const bool in_base = options.frame == "base";
  const Eigen::Isometry3d T_base_lidar = ParsePose(options.T_base_lidar).value();
  if (in_base) {
    translation_ = -T_base_lidar.translation().cast<float>();
  } else {
    rotation_ = T_base_lidar.linear().cast<float>();
  }
  spin_axis_ = T_base_lidar.linear().col(2).cast<float>();
  is_levelling_ = true;
  if (sweeps.empty()) return;
  notices_.push_back(
      std::string(in_base ? "Sweeps are moved from the base's frame to the lidar" : "Sweeps are turned upright") +
      " by input.T_base_lidar; poses are those of a frame at the lidar with the axes of base.");
  for (LidarSweep& sweep : sweeps) Level(&sweep);
  const MountingEstimate mounting = EstimateMounting(sweeps);
  const float tilt = std::acos(std::clamp(mounting.up.z(), -1.0f, 1.0f));
  if (!mounting.ok || (tilt <= kMaxContradiction && IsUsualHeight(mounting.height))) return;
  notices_.push_back("The sweeps contradict input.T_base_lidar: by it the ground is tilted by " + DegreesText(tilt) +
                     " and the lidar is " + MetresText(mounting.height) +
                     " above it; leave the option out to have the mounting found.");
}

std::optional<Scan> LevelledSource::Next() {
  std::optional<Scan> scan;
  if (!ahead_.empty()) {
    scan = std::move(ahead_.front());
    ahead_.pop_front();
  } else if (error_) {
    std::rethrow_exception(std::exchange(error_, nullptr));
  } else {
    scan = source_->Next();
  }
  if (!scan || !is_levelling_) return scan;
  if (auto* sweep = std::get_if<LidarSweep>(&*scan)) Level(sweep);
  return scan;
}

void LevelledSource::Level(LidarSweep* sweep) const {
  for (Eigen::Vector3f& point : sweep->points) point = rotation_ * point + translation_;
  sweep->spin_axis = spin_axis_;
}

std::unique_ptr<ScanSource> OpenLevelledSource(const std::string& path, const SweepFolderOptions& options) {
  return std::make_unique<LevelledSource>(OpenScanSource(path, options), options);
}

}  // namespace arborslam
