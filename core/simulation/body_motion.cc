#include "core/simulation/body_motion.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr uint64_t kStream = 120;
constexpr double kFootfallPeriod = 0.25;  // [s], two in a stride of a trot.
constexpr double kFootfallJitter = 0.2;   // Of the period.
constexpr double kJoltWidth = 0.05;       // [s], standard deviation of the bell curve.
constexpr double kJoltReach = 6.0;        // Of its widths: there the bell curve has vanished.
constexpr double kJolt = DegToRad(0.7);   // Standard deviation.
constexpr double kMaxJolt = DegToRad(3.0);
constexpr double kStumble = 0.03;  // Share of the footfalls that jolt by kMaxJolt or little less.

}  // namespace

const std::vector<std::string>& BodyMotion::Kinds() {
  static const std::vector<std::string>* const kinds = new std::vector<std::string>{"wheeled", "trot", "handheld"};
  return *kinds;
}

BodyMotion::BodyMotion(const std::string& kind, double scale, double duration, uint64_t seed) : scale_(scale) {
  Random random(seed, kStream);
  const auto oscillate = [&](double BodyOffset::*component, double amplitude, double hertz, double wobble) {
    const double frequency = 2.0 * kPi * hertz * random.Uniform(0.95, 1.05);
    const double phase = random.Uniform(-kPi, kPi);
    oscillations_.push_back({component, amplitude, frequency, phase, wobble, frequency * random.Uniform(0.1, 0.3)});
  };
  if (kind == "wheeled") {
    oscillate(&BodyOffset::up, 0.001, 7.0, 0.5);
    oscillate(&BodyOffset::roll, DegToRad(0.12), 5.3, 0.8);
    oscillate(&BodyOffset::pitch, DegToRad(0.12), 6.1, 0.8);
    oscillate(&BodyOffset::roll, DegToRad(0.3), 0.7, 0.8);
    oscillate(&BodyOffset::pitch, DegToRad(0.3), 0.9, 0.8);
    oscillate(&BodyOffset::yaw, DegToRad(0.3), 0.5, 1.0);
    oscillate(&BodyOffset::left, 0.005, 0.6, 1.0);
  } else if (kind == "trot") {
    oscillate(&BodyOffset::left, 0.022, 2.0, 0.8);
    oscillate(&BodyOffset::left, 0.008, 0.7, 0.8);
    oscillate(&BodyOffset::up, 0.01, 4.0, 0.8);
    oscillate(&BodyOffset::roll, DegToRad(0.6), 2.0, 0.8);
    oscillate(&BodyOffset::pitch, DegToRad(0.4), 4.0, 0.8);
    oscillate(&BodyOffset::roll, DegToRad(0.4), 0.35, 1.0);
    oscillate(&BodyOffset::pitch, DegToRad(0.5), 0.25, 1.0);
    oscillate(&BodyOffset::yaw, DegToRad(0.8), 2.0, 0.8);
    oscillate(&BodyOffset::yaw, DegToRad(1.5), 0.4, 1.0);
    const auto count = static_cast<size_t>(std::ceil(duration / kFootfallPeriod)) + 1;
    for (size_t i = 0; i < count; ++i) {
      const double time = kFootfallPeriod * (static_cast<double>(i) + kFootfallJitter * random.Uniform(-1.0, 1.0));
      const bool stumbles = random.Uniform() < kStumble;
      const double roll = random.Gaussian() * kJolt;
      const double pitch = random.Gaussian() * kJolt;
      const double stumble_factor = stumbles ? kMaxJolt * random.Uniform(0.7, 1.0) / std::hypot(roll, pitch) : 1.0;
      footfalls_.push_back({time, std::clamp(stumble_factor * roll, -kMaxJolt, kMaxJolt),
                            std::clamp(stumble_factor * pitch, -kMaxJolt, kMaxJolt), random.Uniform(0.0, 0.01)});
    }
  } else {
    CHECK_EQ(kind, "handheld");
    oscillate(&BodyOffset::roll, DegToRad(1.5), 0.23, 1.5);
    oscillate(&BodyOffset::roll, DegToRad(1.0), 0.9, 1.0);
    oscillate(&BodyOffset::pitch, DegToRad(2.0), 0.17, 1.5);
    oscillate(&BodyOffset::pitch, DegToRad(0.8), 1.8, 1.0);
    oscillate(&BodyOffset::yaw, DegToRad(4.0), 0.13, 1.5);
    oscillate(&BodyOffset::yaw, DegToRad(1.5), 0.9, 1.0);
    oscillate(&BodyOffset::up, 0.03, 1.8, 1.0);
    oscillate(&BodyOffset::left, 0.025, 0.9, 1.0);
  }
}

BodyOffset BodyMotion::At(double time) const {
  BodyOffset offset;
  for (const Oscillation& o : oscillations_) {
    const double phase = o.frequency * time + o.phase + o.wobble * std::sin(o.wobble_frequency * time);
    offset.*o.component += scale_ * o.amplitude * std::sin(phase);
  }
  if (footfalls_.empty()) return offset;
  const double reach = kJoltReach * kJoltWidth + kFootfallJitter * kFootfallPeriod;
  const auto index = [&](double t) {
    return static_cast<size_t>(std::clamp(t / kFootfallPeriod, 0.0, static_cast<double>(footfalls_.size())));
  };
  const size_t end = std::min(footfalls_.size(), index(time + reach) + 1);
  for (size_t i = index(time - reach); i < end; ++i) {
    const double widths = (time - footfalls_[i].time) / kJoltWidth;
    const double bell = std::exp(-0.5 * widths * widths);
    offset.roll += scale_ * bell * footfalls_[i].roll;
    offset.pitch += scale_ * bell * footfalls_[i].pitch;
    offset.up -= scale_ * bell * footfalls_[i].drop;
  }
  return offset;
}

}  // namespace arborslam
