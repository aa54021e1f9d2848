#ifndef ARBORSLAM_APPS_EVALUATE_EVALUATED_RUN_H_
#define ARBORSLAM_APPS_EVALUATE_EVALUATED_RUN_H_

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/association.h"
#include "core/evaluation/map_metrics.h"
#include "core/evaluation/relations.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/geometry/se2.h"

namespace arborslam {

/// One estimated trajectory against its reference.
struct EvaluatedTrajectory {
  std::string estimate_path;
  std::string reference_path;
  AssociationResult association;
  TrajectoryEvaluation evaluation;
};

/// One estimated map against its reference.
struct EvaluatedMap {
  std::string map_path;
  std::string reference_path;
  SE2 T_reference_map;  ///< How the map was moved.
  MapMetrics metrics;
};

/// One estimated trajectory against relations.
struct EvaluatedRelations {
  std::string estimate_path;
  std::string relations_path;
  RelationMetrics metrics;
};

/// What was given of one run; at least one of trajectory, relations and map.
struct EvaluatedRun {
  std::string label;
  std::optional<EvaluatedTrajectory> trajectory;
  std::optional<EvaluatedRelations> relations;
  std::optional<EvaluatedMap> map;
  std::optional<nlohmann::json> offline_summary;  ///< As `ReadOfflineSummary` returns it.
};

/// A figure of a run, of whatever source.
struct Figure {
  std::string key;      ///< For machines, with the unit.
  std::string name;     ///< For people.
  std::string heading;  ///< For narrow columns.
  std::string unit;     ///< Empty where there is none.
  int decimals;         ///< To be printed.
  std::function<std::optional<double>(const EvaluatedRun&)> value;
};

/// All figures: path length, `MetricFields`, those of `RelationMetrics`, `MapMetricFields` and `OfflineFields`.
const std::vector<Figure>& AllFigures();

/// Those of `AllFigures` that can be had of `runs`: their sources were given, though a figure may be absent from all.
std::vector<Figure> FiguresOf(const std::vector<EvaluatedRun>& runs);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_EVALUATE_EVALUATED_RUN_H_
