#include "frontend/tracking/sweep_duration.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace arborslam {
namespace {

// [s], beyond what sweeps last, so that the slope can change its sign between them.
constexpr std::array<double, 10> kCandidates = {-0.05, 0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6};

constexpr size_t kMaxReferences = 3;
constexpr double kReferenceDistance = 0.7;  // [m]
constexpr double kReferenceTurn = 0.4;      // [rad]
constexpr size_t kMinPoints = 20;
constexpr size_t kMaxPoints = 96;            // Of a sweep that is compared.
constexpr size_t kMaxReferencePoints = 288;  // Of a reference.
constexpr float kReach = 0.2f;               // [m], to the nearest point of the references.
constexpr float kScale = 0.05f;              // [m], distance at which a pair's weight has fallen to a quarter.
constexpr uint32_t kBuckets = 1024;
constexpr int kIterations = 2;
constexpr double kPoseWeight = 1.0;  // Ties the pose, as much as one pair at the origin and at the lever arm does.
constexpr double kLeverArm = 5.0;    // [m], typical distance of a point.
// [m/s], of a point at the lever arm: in slower sweeps the velocity is mostly the error of the poses.
constexpr double kLeastMotion = 0.2;
constexpr double kUnusualMotion = 1.25;    // Over the mean: worth a comparison.
constexpr int kMostLeftOut = 7;            // In a row.
constexpr int kMostWithoutReference = 40;  // Comparisons, then the robot is about to stay where it is.
constexpr double kLongestSpan = 2.5;       // [s], over which a velocity is measured.
constexpr size_t kMaxSteps = 256;
constexpr int kBlockSweeps = 5;
constexpr int kMinBlocks = 6;  // For a standard error that can be believed.

constexpr double kUsualPeriods[] = {0.0, 0.05, 0.1, 0.2};  // [s]
constexpr double kLeastSweepsPerStep = 1.9;                // Two, but for jitter.
constexpr double kMostError = 0.02;             // [s], standard error: stamps of poses are right within 0.02 s then.
constexpr double kMostErrorOfCandidate = 0.05;  // [s], the same when the estimate is to tell candidates apart only.
constexpr double kUncertainty = 2.5;            // Standard errors.
constexpr double kRelativeUncertainty = 0.1;    // Of what the model leaves out.

// `point` a time `t` [s] later or earlier on the path of a body that moves with `velocity`, to the second order.
Eigen::Vector2f Moved(const Eigen::Vector2f& point, const PlanarVelocity& velocity, float t) {
  const auto w = static_cast<float>(velocity.angular);
  const Eigen::Vector2f v = velocity.linear.cast<float>();
  const Eigen::Vector2f rate(v.x() - w * point.y(), v.y() + w * point.x());
  return point + t * rate + 0.5f * t * t * w * Eigen::Vector2f(-rate.y(), rate.x());
}

uint32_t Bucket(int x, int y) {
  return (static_cast<uint32_t>(x) * 73856093u ^ static_cast<uint32_t>(y) * 19349663u) % kBuckets;
}

int Cell(float coordinate) { return static_cast<int>(std::floor(coordinate * (1.0f / kReach))); }

// [m/s], about how fast points move past the lidar.
double Motion(const PlanarVelocity& velocity) {
  return velocity.linear.norm() + kLeverArm * std::abs(velocity.angular);
}

}  // namespace

bool SweepDurationEstimator::Add(TimedSweep sweep) {
  CHECK(sweep.phases.empty() || sweep.phases.size() == sweep.points.size());
  if (!latest_.empty() && steps_.size() < kMaxSteps) steps_.push_back(sweep.stamp - latest_.back().stamp);
  latest_.push_back(std::move(sweep));
  if (latest_.size() < 3) return false;
  std::optional<RawSweep> raw = MakeRaw(latest_[0], latest_[1], latest_[2]);
  latest_.pop_front();
  if (!raw) return false;
  const bool is_new = IsChosen(*raw) && Compare(*raw);
  bool is_reference = references_.empty();
  if (!is_reference) {
    const SE2 way = references_.back().T_odom_base.Inverse() * raw->T_odom_base;
    is_reference = way.translation().norm() >= kReferenceDistance || std::abs(way.theta()) >= kReferenceTurn;
  }
  if (is_reference) AddReference(std::move(*raw));
  return is_new;
}

std::optional<SweepDurationEstimator::RawSweep> SweepDurationEstimator::MakeRaw(const TimedSweep& before,
                                                                                const TimedSweep& sweep,
                                                                                const TimedSweep& after) const {
  const double span = after.stamp - before.stamp;
  if (!before.is_matched || !sweep.is_matched || !after.is_matched) return std::nullopt;
  if (sweep.phases.size() < kMinPoints || !(span > 0.0 && span <= kLongestSpan)) return std::nullopt;
  RawSweep raw;
  raw.T_odom_base = sweep.T_odom_base;
  const SE2 T_base_odom = sweep.T_odom_base.Inverse();
  const SE2 from = T_base_odom * before.T_odom_base;
  const SE2 to = T_base_odom * after.T_odom_base;
  raw.velocity.linear = (to.translation() - from.translation()) / span;
  raw.velocity.angular = (to.theta() - from.theta()) / span;
  const auto deskewing_duration = static_cast<float>(sweep.deskewing_duration);
  raw.points.reserve(sweep.points.size());
  raw.phases.reserve(sweep.points.size());
  for (size_t i = 0; i < sweep.points.size(); ++i) {
    const float phase = sweep.phases[i] - 0.5f;
    raw.points.push_back(Moved(sweep.points[i], sweep.deskewing, -phase * deskewing_duration));
    raw.phases.push_back(phase);
  }
  return raw;
}

bool SweepDurationEstimator::IsChosen(const RawSweep& sweep) {
  const double motion = Motion(sweep.velocity);
  if (references_.size() < 2 || motion < kLeastMotion || num_since_reference_ >= kMostWithoutReference) return false;
  sum_motion_ += motion;
  ++num_motions_;
  if (motion * num_motions_ < kUnusualMotion * sum_motion_ && num_left_out_ < kMostLeftOut) {
    ++num_left_out_;
    return false;
  }
  num_left_out_ = 0;
  return true;
}

bool SweepDurationEstimator::Compare(const RawSweep& sweep) {
  const SE2 initial = references_.back().T_odom_base.Inverse() * sweep.T_odom_base;
  const size_t stride = (sweep.points.size() + kMaxPoints - 1) / kMaxPoints;
  const Eigen::Vector2f v = sweep.velocity.linear.cast<float>();
  const auto w = static_cast<float>(sweep.velocity.angular);
  for (size_t c = 0; c < kNumCandidates; ++c) {
    const auto duration = static_cast<float>(kCandidates[c]);
    SE2 pose = initial;
    double slope = 0.0;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      // Of the pose, along the references' axes, and of the duration.
      Eigen::Matrix4f hessian = Eigen::Matrix4f::Zero();
      Eigen::Vector4f gradient = Eigen::Vector4f::Zero();
      const Eigen::Matrix2f rotation = pose.rotation().cast<float>();
      const Eigen::Vector2f translation = pose.translation().cast<float>();
      for (size_t i = 0; i < sweep.points.size(); i += stride) {
        const float phase = sweep.phases[i];
        const Eigen::Vector2f point = Moved(sweep.points[i], sweep.velocity, phase * duration);
        const Eigen::Vector2f lever = rotation * point;
        const Eigen::Vector2f position = lever + translation;
        const CloudPoint* nearest = Nearest(clouds_[c], position);
        if (nearest == nullptr) continue;
        const Eigen::Vector2f residual = position - nearest->position;
        const Eigen::Vector2f rate(v.x() - w * point.y(), v.y() + w * point.x());
        const Eigen::Vector2f shift = phase * (rotation * rate) - nearest->shift;
        // Geman and McClure's.
        const float root = 1.0f / (1.0f + residual.squaredNorm() * (1.0f / (kScale * kScale)));
        const float weight = root * root;
        Eigen::Matrix<float, 2, 4> jacobian;
        jacobian << 1.0f, 0.0f, -lever.y(), shift.x(), 0.0f, 1.0f, lever.x(), shift.y();
        hessian.noalias() += weight * jacobian.transpose() * jacobian;
        gradient.noalias() += weight * jacobian.transpose() * residual;
      }
      hessian.diagonal().head<3>() +=
          Eigen::Vector3d(kPoseWeight, kPoseWeight, kPoseWeight * kLeverArm * kLeverArm).cast<float>();
      const Eigen::Vector3f step = -hessian.topLeftCorner<3, 3>().ldlt().solve(gradient.head<3>());
      slope = static_cast<double>(gradient(3) + hessian.block<1, 3>(3, 0).dot(step));
      pose = SE2(pose.x() + step.x(), pose.y() + step.y(), pose.theta() + step.z());
    }
    block_[c] += slope;
  }
  ++num_since_reference_;
  if (++num_compared_ % kBlockSweeps != 0) return false;
  for (size_t c = 0; c < kNumCandidates; ++c) {
    sum_[c] += block_[c];
    sum_of_squares_[c] += block_[c] * block_[c];
    block_[c] = 0.0;
  }
  return true;
}

void SweepDurationEstimator::AddReference(RawSweep sweep) {
  num_since_reference_ = 0;
  references_.push_back(std::move(sweep));
  if (references_.size() > kMaxReferences) references_.pop_front();
  MakeClouds();
}

void SweepDurationEstimator::MakeClouds() {
  if (references_.empty()) return;
  const SE2 T_last_odom = references_.back().T_odom_base.Inverse();
  for (size_t c = 0; c < kNumCandidates; ++c) {
    Cloud& cloud = clouds_[c];
    const auto duration = static_cast<float>(kCandidates[c]);
    cloud.points.clear();
    cloud.buckets.assign(kBuckets, -1);
    for (const RawSweep& reference : references_) {
      const SE2 T_last_base = T_last_odom * reference.T_odom_base;
      const Eigen::Matrix2f rotation = T_last_base.rotation().cast<float>();
      const Eigen::Vector2f translation = T_last_base.translation().cast<float>();
      const Eigen::Vector2f v = reference.velocity.linear.cast<float>();
      const auto w = static_cast<float>(reference.velocity.angular);
      const size_t stride = (reference.points.size() + kMaxReferencePoints - 1) / kMaxReferencePoints;
      for (size_t i = 0; i < reference.points.size(); i += stride) {
        const Eigen::Vector2f point = Moved(reference.points[i], reference.velocity, reference.phases[i] * duration);
        const Eigen::Vector2f rate(v.x() - w * point.y(), v.y() + w * point.x());
        const Eigen::Vector2f position = rotation * point + translation;
        int32_t& bucket = cloud.buckets[Bucket(Cell(position.x()), Cell(position.y()))];
        cloud.points.push_back({position, reference.phases[i] * (rotation * rate), bucket});
        bucket = static_cast<int32_t>(cloud.points.size()) - 1;
      }
    }
  }
}

const SweepDurationEstimator::CloudPoint* SweepDurationEstimator::Nearest(const Cloud& cloud,
                                                                          const Eigen::Vector2f& position) {
  const int x = Cell(position.x());
  const int y = Cell(position.y());
  const CloudPoint* nearest = nullptr;
  float least = kReach * kReach;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int32_t i = cloud.buckets[Bucket(x + dx, y + dy)]; i >= 0;) {
        const CloudPoint& point = cloud.points[static_cast<size_t>(i)];
        const float distance = (point.position - position).squaredNorm();
        if (distance < least) {
          least = distance;
          nearest = &point;
        }
        i = point.next;
      }
    }
  }
  return nearest;
}

SweepDurationEstimate SweepDurationEstimator::Estimate() const {
  SweepDurationEstimate estimate;
  estimate.num_sweeps = num_compared_;
  if (num_compared_ < kMinBlocks * kBlockSweeps) return estimate;
  // The least of the cost, whose slopes are given.
  size_t best = 0;
  double cost = 0.0;
  double least = 0.0;
  for (size_t c = 1; c < kNumCandidates; ++c) {
    cost += 0.5 * (sum_[c - 1] + sum_[c]) * (kCandidates[c] - kCandidates[c - 1]);
    if (cost < least) {
      least = cost;
      best = c;
    }
  }
  const size_t below = sum_[best] > 0.0 && best > 0 ? best - 1 : best;
  if (below + 1 == kNumCandidates || !(sum_[below] <= 0.0 && sum_[below + 1] > 0.0)) return estimate;
  const double rise = sum_[below + 1] - sum_[below];
  const double share = -sum_[below] / rise;
  const double width = kCandidates[below + 1] - kCandidates[below];
  const double variance = (1.0 - share) * sum_of_squares_[below] + share * sum_of_squares_[below + 1];
  estimate.seconds = kCandidates[below] + share * width;
  estimate.standard_error = std::sqrt(variance) * width / rise;
  return estimate;
}

double SweepDurationEstimator::MedianStep() const {
  if (steps_.empty()) return 0.0;
  std::vector<double> steps = steps_;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

std::optional<double> DecideSweepDuration(const SweepDurationEstimate& estimate, double step) {
  int num_possible = 0;
  double possible = 0.0;
  const auto consider = [&](double candidate) {
    const double uncertainty = kUncertainty * estimate.standard_error + kRelativeUncertainty * candidate;
    if (std::abs(estimate.seconds - candidate) > uncertainty) return;
    ++num_possible;
    possible = candidate;
  };
  for (const double period : kUsualPeriods) {
    if (step >= kLeastSweepsPerStep * period) consider(period);
  }
  if (step > 0.0) consider(step);
  if (num_possible == 1 && estimate.standard_error < kMostErrorOfCandidate) return possible;
  if (estimate.standard_error < kMostError) return std::clamp(estimate.seconds, 0.0, std::max(0.0, step));
  return std::nullopt;
}

}  // namespace arborslam
