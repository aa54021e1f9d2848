#ifndef ARBORSLAM_APPS_EVALUATE_REPORT_H_
#define ARBORSLAM_APPS_EVALUATE_REPORT_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/evaluate/evaluated_run.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"

namespace arborslam {

/// How the runs were compared.
struct EvaluationSettings {
  AlignmentKind alignment = AlignmentKind::kSe2;
  bool common_alignment = false;  ///< One for all runs.
  AssociationOptions association;
  MapComparisonOptions map;
};

/// The runs for people: one run as a list of figures with their units, several as a table with a row each and the mean
/// with its 95 % half width below. Ends with a newline.
/// @param runs     at least one, all of the same sources.
/// @param figures  which to print; "-" where a run does not have one.
/// @param joint    of all runs, when they have one alignment in common.
std::string FormatTable(const std::vector<EvaluatedRun>& runs, const std::vector<Figure>& figures,
                        const EvaluationSettings& settings, const std::optional<JointEvaluation>& joint);

/// A Markdown table with a row for each run and, of several, a last one with the means, "mean ± half width".
std::string FormatMarkdown(const std::vector<EvaluatedRun>& runs, const std::vector<Figure>& figures);

/// The runs for machines, an object with
///   alignment                   "none", "origin", "se2" or "se3"
///   common_alignment            true: one for all runs
///   joint                       of all runs, only then: matched_poses, ate_se2_rmse_m, ate_se2_median_m, ate_se2_max_m
///   max_time_difference_s, max_interpolation_gap_s
///   map_tolerance_m, map_beyond_is_unknown
///                               with maps
///   runs[]                      in the order of the command line, each with
///     label
///     estimate, reference       paths as given; these and those up to z_offset_m with trajectories
///     matched_poses, unmatched_estimate_poses, unmatched_reference_poses
///     T_reference_estimate      4 rows of 4: the alignment
///     z_offset_m                added to the estimate's z before heights are compared
///     relations                 with relations: estimate, relations (paths), matched_relations, unmatched_relations
///     map                       with maps: map, reference, T_reference_map (x, y, yaw) and the counts of `MapMetrics`
///     position_mean_m, ...      the figures of `FiguresOf`; null where not defined
///   summary                     by the key of the figure: runs (N), mean, half_width_95 (1.96 sd / sqrt(N), null for
///                               one run); null where no run has it
nlohmann::ordered_json ToJson(const std::vector<EvaluatedRun>& runs, const EvaluationSettings& settings,
                              const std::optional<JointEvaluation>& joint);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_EVALUATE_REPORT_H_
