#include "core/evaluation/trajectory_metrics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double Rms(const std::vector<double>& values) {
  return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
                   static_cast<double>(values.size()));
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double Distance(const StampedPose3& a, const StampedPose3& b, bool is_spatial) {
  const Eigen::Vector3d difference = b.position - a.position;
  return is_spatial ? difference.norm() : difference.head<2>().norm();
}

double Rotation(const StampedPose3& from, const StampedPose3& to) {
  return AngleDifference(Heading(to.orientation), Heading(from.orientation));
}

std::vector<double> PositionErrors(const std::vector<PosePair>& pairs, bool is_spatial) {
  std::vector<double> errors;
  errors.reserve(pairs.size());
  for (const PosePair& pair : pairs) errors.push_back(Distance(pair.reference, pair.estimate, is_spatial));
  return errors;
}

// How a body leans: its attitude without the yaw, in the order yaw, pitch, roll.
struct Tilt {
  double roll;
  double pitch;
};

Tilt TiltOf(const Eigen::Quaterniond& orientation) {
  const Eigen::Vector3d up = orientation.conjugate() * Eigen::Vector3d::UnitZ();  // As the body sees it.
  return {std::atan2(up.y(), up.z()), std::atan2(-up.x(), std::hypot(up.y(), up.z()))};
}

bool IsTilted(const StampedPose3& pose) { return pose.orientation.x() != 0.0 || pose.orientation.y() != 0.0; }
bool HasHeight(const StampedPose3& pose) { return pose.position.z() != 0.0; }

// True if estimates and references both have a pose that `has` what is asked for.
bool BothHave(const std::vector<PosePair>& pairs, bool (*has)(const StampedPose3&)) {
  return std::any_of(pairs.begin(), pairs.end(), [has](const PosePair& pair) { return has(pair.estimate); }) &&
         std::any_of(pairs.begin(), pairs.end(), [has](const PosePair& pair) { return has(pair.reference); });
}

void MeasureTilt(const std::vector<PosePair>& aligned_pairs, TrajectoryMetrics* metrics) {
  std::vector<double> roll_errors;
  std::vector<double> pitch_errors;
  for (const PosePair& pair : aligned_pairs) {
    const Tilt estimate = TiltOf(pair.estimate.orientation);
    const Tilt reference = TiltOf(pair.reference.orientation);
    roll_errors.push_back(AngleDifference(estimate.roll, reference.roll));
    pitch_errors.push_back(estimate.pitch - reference.pitch);
  }
  metrics->roll_rms = Rms(roll_errors);
  metrics->pitch_rms = Rms(pitch_errors);
}

double HeightOffset(const std::vector<PosePair>& aligned_pairs, AlignmentKind alignment) {
  const auto missing = [](const PosePair& pair) { return pair.reference.position.z() - pair.estimate.position.z(); };
  switch (alignment) {
    case AlignmentKind::kNone:
    case AlignmentKind::kSe3:
      return 0.0;
    case AlignmentKind::kOrigin:
      return missing(aligned_pairs.front());
    case AlignmentKind::kSe2: {
      std::vector<double> offsets;
      for (const PosePair& pair : aligned_pairs) offsets.push_back(missing(pair));
      return Mean(offsets);
    }
  }
  throw std::invalid_argument("no such alignment");
}

void MeasureHeight(const std::vector<PosePair>& aligned_pairs, double z_offset, TrajectoryMetrics* metrics) {
  std::vector<double> height_errors;
  std::vector<double> distances;
  for (const PosePair& pair : aligned_pairs) {
    Eigen::Vector3d error = pair.estimate.position - pair.reference.position;
    error.z() += z_offset;
    height_errors.push_back(error.z());
    distances.push_back(error.norm());
  }
  metrics->z_rms = Rms(height_errors);
  metrics->position_3d_rms = Rms(distances);
}

std::vector<PosePair> Aligned(const std::vector<PosePair>& pairs, const Eigen::Isometry3d& T_reference_estimate) {
  std::vector<PosePair> aligned;
  aligned.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    aligned.push_back({Transform(T_reference_estimate, pair.estimate), pair.reference});
  }
  return aligned;
}

// How estimates are moved onto their references.
struct FrameFit {
  AlignmentKind alignment;
  Eigen::Isometry3d T_reference_estimate;
  Eigen::Isometry3d T_reference_estimate_se2;
  double z_offset;
};

FrameFit FitFrame(const std::vector<PosePair>& pairs, AlignmentKind alignment) {
  FrameFit fit{alignment, Align(pairs, alignment), Align(pairs, AlignmentKind::kSe2), 0.0};
  fit.z_offset = HeightOffset(Aligned(pairs, fit.T_reference_estimate), alignment);
  return fit;
}

// Of the planar positions after the SE(2) alignment.
std::vector<double> AbsoluteErrors(const std::vector<PosePair>& pairs, const FrameFit& fit) {
  return PositionErrors(Aligned(pairs, fit.T_reference_estimate_se2), IsSpatial(AlignmentKind::kSe2));
}

TrajectoryEvaluation EvaluateIn(const FrameFit& fit, const std::vector<PosePair>& pairs, bool has_headings) {
  TrajectoryEvaluation evaluation;
  evaluation.alignment = fit.alignment;
  evaluation.T_reference_estimate = fit.T_reference_estimate;
  evaluation.T_reference_estimate_se2 = fit.T_reference_estimate_se2;
  evaluation.aligned_pairs = Aligned(pairs, evaluation.T_reference_estimate);
  const bool is_spatial = IsSpatial(fit.alignment);
  evaluation.position_errors = PositionErrors(evaluation.aligned_pairs, is_spatial);

  std::vector<double> heading_errors;
  std::vector<double> length_errors;
  std::vector<double> rotation_errors;
  evaluation.path.push_back(0.0);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PosePair& pair = evaluation.aligned_pairs[i];
    heading_errors.push_back(std::abs(Rotation(pair.reference, pair.estimate)));
    if (i == 0) continue;
    const PosePair& last = evaluation.aligned_pairs[i - 1];
    const double true_length = Distance(last.reference, pair.reference, is_spatial);
    length_errors.push_back(Distance(last.estimate, pair.estimate, is_spatial) - true_length);
    rotation_errors.push_back(
        AngleDifference(Rotation(last.estimate, pair.estimate), Rotation(last.reference, pair.reference)));
    evaluation.path.push_back(evaluation.path.back() + true_length);
  }

  TrajectoryMetrics& metrics = evaluation.metrics;
  metrics.position_mean = Mean(evaluation.position_errors);
  metrics.position_rms = Rms(evaluation.position_errors);
  metrics.end_error = evaluation.position_errors.back();
  if (has_headings) {
    metrics.heading_mean = Mean(heading_errors);
    metrics.heading_rms = Rms(heading_errors);
  }
  if (!length_errors.empty()) {
    metrics.step_length_mean = Mean(length_errors);
    metrics.step_length_rms = Rms(length_errors);
  }
  if (has_headings && !rotation_errors.empty()) {
    metrics.step_rotation_mean = Mean(rotation_errors);
    metrics.step_rotation_rms = Rms(rotation_errors);
  }
  if (evaluation.path_length() > 0.0) {
    metrics.position_percent = metrics.position_mean / evaluation.path_length() * 100.0;
  }

  if (has_headings && BothHave(pairs, &IsTilted)) MeasureTilt(evaluation.aligned_pairs, &metrics);
  if (BothHave(pairs, &HasHeight)) {
    evaluation.z_offset = fit.z_offset;
    MeasureHeight(evaluation.aligned_pairs, evaluation.z_offset, &metrics);
  }

  const std::vector<double> absolute_errors = AbsoluteErrors(pairs, fit);
  metrics.ate_rmse = Rms(absolute_errors);
  metrics.ate_median = Median(absolute_errors);
  metrics.ate_max = *std::max_element(absolute_errors.begin(), absolute_errors.end());
  return evaluation;
}

}  // namespace

TrajectoryEvaluation EvaluateTrajectory(const std::vector<PosePair>& pairs, bool has_headings,
                                        AlignmentKind alignment) {
  return EvaluateIn(FitFrame(pairs, alignment), pairs, has_headings);
}

JointEvaluation EvaluateTogether(const std::vector<RunPairs>& runs, AlignmentKind alignment) {
  std::vector<PosePair> all;
  for (const RunPairs& run : runs) {
    if (run.pairs.empty()) throw std::invalid_argument("a run has no pairs");
    all.insert(all.end(), run.pairs.begin(), run.pairs.end());
  }
  const FrameFit fit = FitFrame(all, alignment);
  JointEvaluation joint;
  for (const RunPairs& run : runs) joint.runs.push_back(EvaluateIn(fit, run.pairs, run.has_headings));
  const std::vector<double> errors = AbsoluteErrors(all, fit);
  joint.num_pairs = all.size();
  joint.ate_rmse = Rms(errors);
  joint.ate_median = Median(errors);
  joint.ate_max = *std::max_element(errors.begin(), errors.end());
  return joint;
}

const std::vector<MetricField>& MetricFields() {
  using M = TrajectoryMetrics;
  using Value = std::optional<double>;
  static const std::vector<MetricField> fields = {
      {"position_mean_m", "position error, mean norm (e_p)", "e_p", "m",
       [](const M& m) -> Value { return m.position_mean; }},
      {"position_rms_m", "position error, RMS", "RMS_p", "m", [](const M& m) -> Value { return m.position_rms; }},
      {"heading_mean_rad", "heading error, mean absolute (e_theta)", "e_th", "rad",
       [](const M& m) { return m.heading_mean; }},
      {"heading_rms_rad", "heading error, RMS", "RMS_th", "rad", [](const M& m) { return m.heading_rms; }},
      {"step_length_mean_m", "step length error, mean signed (e_dp)", "e_dp", "m",
       [](const M& m) { return m.step_length_mean; }},
      {"step_length_rms_m", "step length error, RMS", "RMS_dp", "m", [](const M& m) { return m.step_length_rms; }},
      {"step_rotation_mean_rad", "step rotation error, mean signed (e_dtheta)", "e_dth", "rad",
       [](const M& m) { return m.step_rotation_mean; }},
      {"step_rotation_rms_rad", "step rotation error, RMS", "RMS_dth", "rad",
       [](const M& m) { return m.step_rotation_rms; }},
      {"position_percent", "position error over path length (e_p%)", "e_p%", "%",
       [](const M& m) { return m.position_percent; }},
      {"end_error_m", "position error of the last pose (e_end)", "e_end", "m",
       [](const M& m) -> Value { return m.end_error; }},
      {"roll_rms_rad", "roll error, RMS", "RMS_rol", "rad", [](const M& m) { return m.roll_rms; }},
      {"pitch_rms_rad", "pitch error, RMS", "RMS_pit", "rad", [](const M& m) { return m.pitch_rms; }},
      {"z_rms_m", "height error, RMS", "RMS_z", "m", [](const M& m) { return m.z_rms; }},
      {"position_3d_rms_m", "position error in space, RMS", "RMS_3d", "m",
       [](const M& m) { return m.position_3d_rms; }},
      {"ate_se2_rmse_m", "ATE after SE(2) alignment, RMSE", "ATE", "m", [](const M& m) -> Value { return m.ate_rmse; }},
      {"ate_se2_median_m", "ATE after SE(2) alignment, median", "ATE_med", "m",
       [](const M& m) -> Value { return m.ate_median; }},
      {"ate_se2_max_m", "ATE after SE(2) alignment, maximum", "ATE_max", "m",
       [](const M& m) -> Value { return m.ate_max; }},
  };
  return fields;
}

std::optional<RunSummary> SummarizeRuns(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  RunSummary summary;
  summary.num_runs = values.size();
  summary.mean = Mean(values);
  if (values.size() >= 2) {
    const auto num_runs = static_cast<double>(values.size());
    double sum_of_squares = 0.0;
    for (const double value : values) sum_of_squares += (value - summary.mean) * (value - summary.mean);
    summary.half_width = 1.96 * std::sqrt(sum_of_squares / (num_runs - 1.0)) / std::sqrt(num_runs);
  }
  return summary;
}

}  // namespace arborslam
