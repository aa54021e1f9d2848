#include "core/simulation/carrier.h"

#include <algorithm>
#include <cmath>

#include "core/config/edit_distance.h"
#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr uint64_t kStream = 130;
constexpr double kRest = 1.0;            // [s] at the beginning and at the end.
constexpr double kRamp = 2.0;            // [s] from rest to full speed.
constexpr double kSurge = 0.1;           // Share of the speed by which it rises and falls.
constexpr double kSurgeFrequency = 0.9;  // [rad/s].
constexpr double kBodyHeight = 0.6;      // Of the sensor's height: about there the carrier tilts.
constexpr double kDifference = 0.05;     // [s], for velocities.

// A smooth step from 0 at 0 to 1 at 1, and its integral from 0.
double Step(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}
double StepIntegral(double u) {
  const double v = std::clamp(u, 0.0, 1.0);
  return v * v * v * (1.0 - 0.5 * v) + std::max(0.0, u - 1.0);
}

}  // namespace

std::string CarrierOptions::Validate() const {
  const auto& kinds = BodyMotion::Kinds();
  if (std::find(kinds.begin(), kinds.end(), motion) == kinds.end()) {
    return Violation("motion", motion, "be wheeled, trot or handheld");
  }
  if (!(speed >= 0.01 && speed <= 20.0)) return Violation("speed", speed, "lie in [0.01, 20]");
  if (!(sensor_height >= 0.1 && sensor_height <= 10.0)) {
    return Violation("sensor_height", sensor_height, "lie in [0.1, 10]");
  }
  if (!(turn_radius >= 0.1 && turn_radius <= 20.0)) return Violation("turn_radius", turn_radius, "lie in [0.1, 20]");
  if (!(wander >= 0.0 && wander <= 5.0)) return Violation("wander", wander, "lie in [0, 5]");
  if (!(restlessness >= 0.0 && restlessness <= 5.0)) return Violation("restlessness", restlessness, "lie in [0, 5]");
  if (!(ground_following >= 0.0 && ground_following <= 1.0)) {
    return Violation("ground_following", ground_following, "lie in [0, 1]");
  }
  return "";
}

Carrier::Carrier(const CarrierOptions& options, const ClosedPath& path, const UnevenGround* terrain, uint64_t seed)
    : options_(options),
      path_(path, 0.5 * options.turn_radius, options.wander, seed),
      terrain_(terrain),
      duration_(2.0 * kRest + kRamp + path_.Length() / options.speed),
      body_motion_(options.motion, options.restlessness, duration_, seed) {
  surge_phase_ = Random(seed, kStream).Uniform(-kPi, kPi);
}

double Carrier::SpeedShare(double time) const {
  return Step((time - kRest) / kRamp) * Step((duration_ - kRest - time) / kRamp);
}

double Carrier::NominalDistance(double time) const {
  const double begin = StepIntegral((time - kRest) / kRamp);
  const double end = StepIntegral((time - (duration_ - kRest - kRamp)) / kRamp);
  return kRamp * (begin - end);
}

double Carrier::DistanceAt(double time) const {
  const double surge = kSurge / kSurgeFrequency * std::sin(kSurgeFrequency * time + surge_phase_);
  // Squared, it comes and goes so slowly that the carrier never moves back.
  const double share = SpeedShare(time);
  return options_.speed * (NominalDistance(time) + share * share * surge);
}

Eigen::Isometry3d Carrier::PoseAt(double time) const {
  const SE2 place = path_.At(DistanceAt(time));
  BodyOffset offset = body_motion_.At(time);
  // Even a robot that stands moves a little.
  const double liveliness = 0.1 + 0.9 * SpeedShare(time);
  const Eigen::Vector2d position = place * Eigen::Vector2d(0.0, liveliness * offset.left);
  const double heading = place.theta() + liveliness * offset.yaw;
  const Eigen::Vector2d gradient = terrain_->SmoothGradient(position);
  const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const double pitch = liveliness * offset.pitch - options_.ground_following * std::atan(gradient.dot(ahead));
  const double roll = liveliness * offset.roll + options_.ground_following * std::atan(gradient.dot(left));

  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
  const double body = kBodyHeight * options_.sensor_height;
  const Eigen::Vector3d pivot(position.x(), position.y(),
                              terrain_->SmoothHeight(position) + body + liveliness * offset.up);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.toRotationMatrix();
  pose.translation() = pivot + rotation * Eigen::Vector3d(0.0, 0.0, options_.sensor_height - body);
  return pose;
}

OdometryVelocity Carrier::VelocityAt(double time) const {
  const SE2 before = path_.At(DistanceAt(time - kDifference));
  const SE2 after = path_.At(DistanceAt(time + kDifference));
  const SE2 here = path_.At(DistanceAt(time));
  const Eigen::Vector2d step = here.rotation().transpose() * (after.translation() - before.translation());
  const double span = 2.0 * kDifference;
  return {step.x() / span, step.y() / span, AngleDifference(after.theta(), before.theta()) / span};
}

}  // namespace arborslam
