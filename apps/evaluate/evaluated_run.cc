#include "apps/evaluate/evaluated_run.h"

#include <algorithm>

#include "apps/evaluate/offline_summary.h"
#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr int kDecimals = 4;

std::vector<Figure> TrajectoryFigures() {
  std::vector<Figure> figures;
  const auto add = [&figures](const char* key, const char* name, const char* heading, const char* unit,
                              const auto& value) {
    figures.push_back({key, name, heading, unit, kDecimals, [value](const EvaluatedRun& run) -> std::optional<double> {
                         if (!run.trajectory) return std::nullopt;
                         return value(run.trajectory->evaluation);
                       }});
  };
  add("path_length_m", "path length of the reference", "path", "m",
      [](const TrajectoryEvaluation& evaluation) { return std::optional<double>(evaluation.path_length()); });
  for (const MetricField& field : MetricFields()) {
    add(field.key, field.name, field.heading, field.unit,
        [value = field.value](const TrajectoryEvaluation& evaluation) { return value(evaluation.metrics); });
  }
  return figures;
}

std::vector<Figure> RelationFigures() {
  constexpr double kDegrees = 180.0 / kPi;
  std::vector<Figure> figures;
  const auto add = [&figures](const char* key, const char* name, const char* heading, const char* unit,
                              double RelationMetrics::*value, double scale) {
    figures.push_back(
        {key, name, heading, unit, kDecimals, [value, scale](const EvaluatedRun& run) -> std::optional<double> {
           if (!run.relations) return std::nullopt;
           return scale * (run.relations->metrics.*value);
         }});
  };
  add("relations_translation_mean_m", "relations, translation error, mean", "rel_t", "m",
      &RelationMetrics::translation_mean, 1.0);
  add("relations_translation_sd_m", "relations, translation error, sd", "rel_t_sd", "m",
      &RelationMetrics::translation_sd, 1.0);
  add("relations_translation_max_m", "relations, translation error, max", "rel_tmax", "m",
      &RelationMetrics::translation_max, 1.0);
  add("relations_rotation_mean_deg", "relations, rotation error, mean", "rel_r", "deg", &RelationMetrics::rotation_mean,
      kDegrees);
  add("relations_rotation_sd_deg", "relations, rotation error, sd", "rel_r_sd", "deg", &RelationMetrics::rotation_sd,
      kDegrees);
  add("relations_rotation_max_deg", "relations, rotation error, max", "rel_rmax", "deg", &RelationMetrics::rotation_max,
      kDegrees);
  return figures;
}

std::vector<Figure> MapFigures() {
  std::vector<Figure> figures;
  for (const MapMetricField& field : MapMetricFields()) {
    figures.push_back({field.key, field.name, field.heading, "", kDecimals,
                       [value = field.value](const EvaluatedRun& run) -> std::optional<double> {
                         if (!run.map) return std::nullopt;
                         return value(run.map->metrics);
                       }});
  }
  return figures;
}

std::vector<Figure> SummaryFigures() {
  std::vector<Figure> figures;
  for (const OfflineField& field : OfflineFields()) {
    figures.push_back({field.key, field.name, field.heading, field.unit, field.decimals,
                       [value = field.value](const EvaluatedRun& run) -> std::optional<double> {
                         if (!run.offline_summary) return std::nullopt;
                         return value(*run.offline_summary);
                       }});
  }
  return figures;
}

void Append(const std::vector<Figure>& more, std::vector<Figure>* figures) {
  figures->insert(figures->end(), more.begin(), more.end());
}

}  // namespace

const std::vector<Figure>& AllFigures() {
  static const std::vector<Figure> figures = [] {
    std::vector<Figure> all = TrajectoryFigures();
    Append(RelationFigures(), &all);
    Append(MapFigures(), &all);
    Append(SummaryFigures(), &all);
    return all;
  }();
  return figures;
}

std::vector<Figure> FiguresOf(const std::vector<EvaluatedRun>& runs) {
  const auto any = [&runs](const auto& has) { return std::any_of(runs.begin(), runs.end(), has); };
  std::vector<Figure> figures;
  if (any([](const EvaluatedRun& run) { return run.trajectory.has_value(); })) Append(TrajectoryFigures(), &figures);
  if (any([](const EvaluatedRun& run) { return run.relations.has_value(); })) Append(RelationFigures(), &figures);
  if (any([](const EvaluatedRun& run) { return run.map.has_value(); })) Append(MapFigures(), &figures);
  if (any([](const EvaluatedRun& run) { return run.offline_summary.has_value(); })) Append(SummaryFigures(), &figures);
  return figures;
}

}  // namespace arborslam
