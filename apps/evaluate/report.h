#ifndef ARBORSLAM_APPS_EVALUATE_REPORT_H_
#define ARBORSLAM_APPS_EVALUATE_REPORT_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"

namespace arborslam {

/// One estimate against its reference.
struct EvaluatedRun {
  std::string estimate_path;
  std::string reference_path;
  AssociationResult association;
  TrajectoryEvaluation evaluation;
};

/// The runs for people: one run as a list of figures with their units, several as a table with a row each and the mean
/// with its 95 % half width below. Ends with a newline.
/// @param runs at least one, all aligned alike.
std::string FormatTable(const std::vector<EvaluatedRun>& runs);

/// The runs for machines, an object with
///   alignment                   "none", "origin", "se2" or "se3"
///   max_time_difference_s, max_interpolation_gap_s
///   runs[]                      in the order of the command line, each with
///     estimate, reference       paths as given
///     matched_poses, unmatched_estimate_poses, unmatched_reference_poses
///     path_length_m             of the reference over the matched poses
///     T_reference_estimate      4 rows of 4: the alignment
///     position_mean_m, ...      the figures of `MetricFields`; null where not defined
///   summary                     by the key of the figure: runs (N), mean, half_width_95 (1.96 sd / sqrt(N), null for
///   one
///                               run); null where no run has it
nlohmann::ordered_json ToJson(const std::vector<EvaluatedRun>& runs, const AssociationOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_EVALUATE_REPORT_H_
