#ifndef ARBORSLAM_CORE_EVALUATION_TRAJECTORY_METRICS_H_
#define ARBORSLAM_CORE_EVALUATION_TRAJECTORY_METRICS_H_

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/evaluation/alignment.h"
#include "core/evaluation/association.h"

namespace arborslam {

/// The figures of one run (Nazate-Burgos et al. 2026, section on metrics), over its N matched poses. All but the last
/// three depend on the alignment; lengths and distances are taken in the plane, except after an alignment in space.
/// A figure is absent where it is not defined.
///
/// Roll, pitch and height are no concern of the paper's. Roll and pitch are those of yaw, pitch, roll (Z-Y'-X''): what
/// is left of the attitude when the yaw is taken off, that is how the body leans in the frame whose z axis points up.
/// An alignment in the plane does not touch them; after one in space they are the aligned estimate's. Where no pose of
/// estimate or reference has any roll or pitch, or where none has a z other than 0, that trajectory is planar and the
/// figures of it are absent.
struct TrajectoryMetrics {
  double position_mean = 0.0;                ///< e_p [m]: mean norm of the position error.
  double position_rms = 0.0;                 ///< RMS of the same [m].
  std::optional<double> heading_mean;        ///< e_theta [rad]: mean absolute heading error; needs headings.
  std::optional<double> heading_rms;         ///< RMS of the same [rad].
  std::optional<double> step_length_mean;    ///< e_dp [m]: mean of estimated less true step length; needs N >= 2.
  std::optional<double> step_length_rms;     ///< RMS of the same [m].
  std::optional<double> step_rotation_mean;  ///< e_dtheta [rad]: mean of estimated less true step rotation; needs both.
  std::optional<double> step_rotation_rms;   ///< RMS of the same [rad].
  std::optional<double> position_percent;    ///< e_p% [%]: e_p / path length * 100; needs a path that is not 0.
  double end_error = 0.0;                    ///< e_end [m]: position error of the last pose.
  std::optional<double> roll_rms;            ///< RMS of estimated less true roll [rad]; needs attitudes.
  std::optional<double> pitch_rms;           ///< RMS of estimated less true pitch [rad]; needs attitudes.
  std::optional<double> z_rms;               ///< RMS of the height error [m], see `z_offset`; needs heights.
  std::optional<double> position_3d_rms;     ///< RMS of the norm of the error in x, y and height [m]; needs heights.
  double ate_rmse = 0.0;                     ///< [m] after SE(2) alignment, whatever the alignment of the others.
  double ate_median = 0.0;                   ///< [m] likewise.
  double ate_max = 0.0;                      ///< [m] likewise.
};

/// One run, aligned and measured.
struct TrajectoryEvaluation {
  AlignmentKind alignment = AlignmentKind::kSe2;
  Eigen::Isometry3d T_reference_estimate = Eigen::Isometry3d::Identity();
  /// The alignment that the ATE is taken after: `kSe2`, whatever `alignment` is.
  Eigen::Isometry3d T_reference_estimate_se2 = Eigen::Isometry3d::Identity();
  /// [m], added to the aligned estimate's z before heights are compared, and to nothing else. Planar alignments leave
  /// the height open: with `kSe2` the mean heights coincide, with `kOrigin` the first ones; otherwise this is 0.
  double z_offset = 0.0;
  std::vector<PosePair> aligned_pairs;  ///< The estimates moved by T_reference_estimate.
  std::vector<double> path;             ///< [m] length of the reference's path from the first pair to this one.
  std::vector<double> position_errors;  ///< [m], one per pair.
  TrajectoryMetrics metrics;

  double path_length() const { return path.back(); }
};

/// Aligns the estimates of `pairs` to their references and measures what is left. A step leads from one pair to the
/// next, over poses that have no partner.
/// @param pairs in the order of their stamps, at least one. Throws `std::invalid_argument`.
/// @param has_headings whether both trajectories have orientations, see `AssociationResult`.
TrajectoryEvaluation EvaluateTrajectory(const std::vector<PosePair>& pairs, bool has_headings, AlignmentKind alignment);

/// The pairs of one run.
struct RunPairs {
  std::vector<PosePair> pairs;  ///< In the order of their stamps.
  bool has_headings = false;    ///< Whether both trajectories have orientations, see `AssociationResult`.
};

/// Several runs, moved and measured together.
struct JointEvaluation {
  std::vector<TrajectoryEvaluation> runs;  ///< Each after the alignment that all have in common.
  size_t num_pairs = 0;                    ///< Of all runs.
  // Over the pairs of all runs.
  double ate_rmse = 0.0;    ///< [m] after the SE(2) alignment that fits all runs together best.
  double ate_median = 0.0;  ///< [m] likewise.
  double ate_max = 0.0;     ///< [m] likewise.
};

/// The same for runs whose estimates are in one frame and whose references are in one frame: one alignment, of all
/// pairs as if they were of one run (`kOrigin`: of the first pair of the first), moves all of them, so that what the
/// runs lie off each other counts as error.
/// @param runs at least one, each of at least one pair. Throws `std::invalid_argument`.
JointEvaluation EvaluateTogether(const std::vector<RunPairs>& runs, AlignmentKind alignment);

/// How a figure of `TrajectoryMetrics` is presented.
struct MetricField {
  const char* key;      ///< For machines, with the unit: "position_rms_m".
  const char* name;     ///< For people: "position error, RMS".
  const char* heading;  ///< For narrow columns: "RMS e_p".
  const char* unit;     ///< "m", "rad" or "%".
  std::optional<double> (*value)(const TrajectoryMetrics&);
};

/// The figures in the order of the struct.
const std::vector<MetricField>& MetricFields();

/// A figure over N runs.
struct RunSummary {
  size_t num_runs = 0;  ///< N, runs in which the figure is defined.
  double mean = 0.0;
  std::optional<double> half_width;  ///< 1.96 sd / sqrt(N), sd with N - 1; needs N >= 2.
};

/// The mean of `values` over runs and its 95 % half width; nothing if there are none.
std::optional<RunSummary> SummarizeRuns(const std::vector<double>& values);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_EVALUATION_TRAJECTORY_METRICS_H_
