#include "apps/evaluate/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr size_t kMinLabelWidth = 6;
constexpr size_t kCellWidth = 8;
constexpr char kAbsent[] = "-";

std::string Describe(AlignmentKind kind) {
  switch (kind) {
    case AlignmentKind::kNone:
      return "none; planar errors";
    case AlignmentKind::kOrigin:
      return "origin (first poses coincide); planar errors";
    case AlignmentKind::kSe2:
      return "SE(2), Umeyama without scale; planar errors";
    case AlignmentKind::kSe3:
      return "SE(3), Umeyama without scale; errors in space";
  }
  return "";
}

std::string Describe(const EvaluationSettings& settings) {
  return Describe(settings.alignment) + (settings.common_alignment ? "; one for all runs" : "");
}

std::string JointText(const JointEvaluation& joint) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "\njoint: %zu pairs, ATE after one SE(2) alignment of all runs: RMSE %.4f m, median %.4f m, "
                "maximum %.4f m\n",
                joint.num_pairs, joint.ate_rmse, joint.ate_median, joint.ate_max);
  return text;
}

std::string Number(const std::optional<double>& value, const Figure& figure) {
  if (!value) return kAbsent;
  // What rounds to 0 has no sign.
  const double least = 0.5 * std::pow(10.0, -figure.decimals);
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", figure.decimals, std::abs(*value) < least ? 0.0 : *value);
  return text;
}

std::string PadLeft(const std::string& text, size_t width) {
  return std::string(width - std::min(width, text.size()), ' ') + text;
}

std::string PadRight(const std::string& text, size_t width) {
  return text + std::string(width - std::min(width, text.size()), ' ');
}

std::string MatchedText(const EvaluatedTrajectory& trajectory) {
  const AssociationResult& association = trajectory.association;
  return std::to_string(association.pairs.size()) +
         " pairs; without a partner: " + std::to_string(association.unmatched_estimate) + " of the estimate, " +
         std::to_string(association.unmatched_reference) + " of the reference";
}

std::string RelationsText(const RelationMetrics& metrics) {
  return std::to_string(metrics.num_matched) + " of " + std::to_string(metrics.num_relations) + " relations";
}

std::string MapText(const MapMetrics& metrics) {
  return std::to_string(metrics.estimated_occupied) + " occupied cells, " + std::to_string(metrics.estimated_right) +
         " right, " + std::to_string(metrics.false_positives) + " false, " + std::to_string(metrics.outside) +
         " outside of the reference; " + std::to_string(metrics.reference_found) + " of its " +
         std::to_string(metrics.reference_occupied) + " found";
}

std::string ToleranceText(const EvaluationSettings& settings) {
  return ShortestText(settings.map.tolerance) + " m; beyond the reference's edges " +
         (settings.map.beyond_is_unknown ? "cells are not judged" : "cells are false");
}

std::optional<RunSummary> Summarize(const std::vector<EvaluatedRun>& runs, const Figure& figure) {
  std::vector<double> values;
  for (const EvaluatedRun& run : runs) {
    if (const std::optional<double> value = figure.value(run)) values.push_back(*value);
  }
  return SummarizeRuns(values);
}

std::string FormatOneRun(const EvaluatedRun& run, const std::vector<Figure>& figures,
                         const EvaluationSettings& settings) {
  std::string text;
  if (run.trajectory) {
    text += "estimate     " + run.trajectory->estimate_path + "\n";
    text += "reference    " + run.trajectory->reference_path + "\n";
    text += "matched      " + MatchedText(*run.trajectory) + "\n";
    text += "alignment    " + Describe(settings) + "\n";
  }
  if (run.relations) {
    text += "estimate     " + run.relations->estimate_path + "\n";
    text += "relations    " + run.relations->relations_path + "\n";
    text += "matched      " + RelationsText(run.relations->metrics) + "\n";
  }
  if (run.map) {
    text += "map          " + run.map->map_path + "\n";
    text += "reference    " + run.map->reference_path + "\n";
    text += "compared     " + MapText(run.map->metrics) + "\n";
    text += "tolerance    " + ToleranceText(settings) + "\n";
  }
  text += "\n";
  size_t name_width = 0;
  for (const Figure& figure : figures) name_width = std::max(name_width, figure.name.size());
  for (const Figure& figure : figures) {
    const std::optional<double> value = figure.value(run);
    text += PadRight(figure.name, name_width) + PadLeft(Number(value, figure), 12);
    if (value && !figure.unit.empty()) text += " " + figure.unit;
    text += "\n";
  }
  return text;
}

std::string FormatRow(const std::string& label, size_t label_width, const std::vector<std::string>& cells) {
  std::string row = PadRight(label, label_width);
  for (const std::string& cell : cells) row += " " + PadLeft(cell, kCellWidth);
  return row + "\n";
}

std::string FormatManyRuns(const std::vector<EvaluatedRun>& runs, const std::vector<Figure>& figures,
                           const EvaluationSettings& settings) {
  std::string text;
  if (runs.front().trajectory) text += "alignment  " + Describe(settings) + "\n";
  if (runs.front().map) text += "tolerance  " + ToleranceText(settings) + " (maps)\n";
  size_t label_width = kMinLabelWidth;
  for (const EvaluatedRun& run : runs) {
    label_width = std::max(label_width, run.label.size());
    if (run.trajectory) {
      text += "run " + run.label + "      " + run.trajectory->estimate_path + " against " +
              run.trajectory->reference_path + ": " + MatchedText(*run.trajectory) + "\n";
    }
    if (run.relations) {
      text += "run " + run.label + "      " + run.relations->estimate_path + " against " +
              run.relations->relations_path + ": " + RelationsText(run.relations->metrics) + "\n";
    }
    if (run.map) {
      text += "run " + run.label + "      " + run.map->map_path + " against " + run.map->reference_path + ": " +
              MapText(run.map->metrics) + "\n";
    }
  }
  text += "\n";
  std::vector<std::string> headings;
  std::vector<std::string> units;
  std::vector<std::string> means;
  std::vector<std::string> half_widths;
  for (const Figure& figure : figures) {
    headings.push_back(figure.heading);
    units.push_back(figure.unit.empty() ? "" : "[" + figure.unit + "]");
    const std::optional<RunSummary> summary = Summarize(runs, figure);
    means.push_back(summary ? Number(summary->mean, figure) : kAbsent);
    half_widths.push_back(summary ? Number(summary->half_width, figure) : kAbsent);
  }
  text += FormatRow("run", label_width, headings) + FormatRow("", label_width, units);
  for (const EvaluatedRun& run : runs) {
    std::vector<std::string> cells;
    for (const Figure& figure : figures) cells.push_back(Number(figure.value(run), figure));
    text += FormatRow(run.label, label_width, cells);
  }
  text += FormatRow("mean", label_width, means) + FormatRow("+-", label_width, half_widths);
  text += "\n+- is 1.96 sd / sqrt(N).\n";
  if (runs.front().trajectory) {
    text += "e: mean error, RMS: its root mean square; p: position, th: heading, dp: step length, dth: step rotation, ";
    text += "rol: roll,\npit: pitch, 3d: position in space. ";
    text += "ATE, ATE_med, ATE_max: RMSE, median and maximum after SE(2) alignment.\n";
  }
  if (runs.front().relations) {
    text += "rel_t, rel_r: mean amounts of the errors of relative poses (Kuemmerle et al. 2009).\n";
  }
  if (runs.front().map) text += "m_prec, m_sens, m_acc: precision, sensitivity and accuracy of the map.\n";
  if (runs.front().offline_summary) {
    text += "odo_ATE: ATE of the causal trajectory; t_med, t_p95: time a scan, median and 95th percentile; reject, ";
    text += "degen:\nscans rejected, and with a direction that nothing held.\n";
  }
  return text;
}

// `text` as one cell of a Markdown table.
std::string MarkdownCell(const std::string& text) {
  std::string cell;
  for (const char character : text) {
    if (character == '|') cell += '\\';
    cell += character == '\n' ? ' ' : character;
  }
  return cell;
}

std::string MarkdownRow(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& cell : cells) row += " " + MarkdownCell(cell) + " |";
  return row + "\n";
}

nlohmann::ordered_json NumberOrNull(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json MapToJson(const EvaluatedMap& map) {
  const MapMetrics& metrics = map.metrics;
  return {{"map", map.map_path},
          {"reference", map.reference_path},
          {"T_reference_map", {map.T_reference_map.x(), map.T_reference_map.y(), map.T_reference_map.theta()}},
          {"estimated_occupied_cells", metrics.estimated_occupied},
          {"reference_occupied_cells", metrics.reference_occupied},
          {"estimated_right_cells", metrics.estimated_right},
          {"reference_found_cells", metrics.reference_found},
          {"right_cells", metrics.right},
          {"false_positive_cells", metrics.false_positives},
          {"false_negative_cells", metrics.false_negatives},
          {"true_negative_cells", metrics.true_negatives},
          {"outside_cells", metrics.outside},
          {"unjudged_cells", metrics.unjudged}};
}

nlohmann::ordered_json RunToJson(const EvaluatedRun& run, const std::vector<Figure>& figures) {
  nlohmann::ordered_json json;
  json["label"] = run.label;
  if (run.trajectory) {
    json["estimate"] = run.trajectory->estimate_path;
    json["reference"] = run.trajectory->reference_path;
    json["matched_poses"] = run.trajectory->association.pairs.size();
    json["unmatched_estimate_poses"] = run.trajectory->association.unmatched_estimate;
    json["unmatched_reference_poses"] = run.trajectory->association.unmatched_reference;
    const Eigen::Matrix4d T = run.trajectory->evaluation.T_reference_estimate.matrix();
    for (Eigen::Index row = 0; row < 4; ++row) {
      json["T_reference_estimate"].push_back({T(row, 0), T(row, 1), T(row, 2), T(row, 3)});
    }
    json["z_offset_m"] = run.trajectory->evaluation.z_offset;
  }
  if (run.relations) {
    const RelationMetrics& metrics = run.relations->metrics;
    json["relations"] = {{"estimate", run.relations->estimate_path},
                         {"relations", run.relations->relations_path},
                         {"matched_relations", metrics.num_matched},
                         {"unmatched_relations", metrics.num_relations - metrics.num_matched}};
  }
  if (run.map) json["map"] = MapToJson(*run.map);
  for (const Figure& figure : figures) json[figure.key] = NumberOrNull(figure.value(run));
  return json;
}

}  // namespace

std::string FormatTable(const std::vector<EvaluatedRun>& runs, const std::vector<Figure>& figures,
                        const EvaluationSettings& settings, const std::optional<JointEvaluation>& joint) {
  return (runs.size() == 1 ? FormatOneRun(runs.front(), figures, settings) : FormatManyRuns(runs, figures, settings)) +
         (joint ? JointText(*joint) : "");
}

std::string FormatMarkdown(const std::vector<EvaluatedRun>& runs, const std::vector<Figure>& figures) {
  std::vector<std::string> headings = {"run"};
  std::string rule = "|---|";
  std::vector<std::string> means = {"mean"};
  for (const Figure& figure : figures) {
    headings.push_back(figure.heading + (figure.unit.empty() ? "" : " [" + figure.unit + "]"));
    rule += "---:|";
    const std::optional<RunSummary> summary = Summarize(runs, figure);
    means.push_back(summary ? Number(summary->mean, figure) : kAbsent);
    if (summary && summary->half_width) means.back() += " ± " + Number(summary->half_width, figure);
  }
  std::string text = MarkdownRow(headings) + rule + "\n";
  for (const EvaluatedRun& run : runs) {
    std::vector<std::string> cells = {run.label};
    for (const Figure& figure : figures) cells.push_back(Number(figure.value(run), figure));
    text += MarkdownRow(cells);
  }
  if (runs.size() > 1) text += MarkdownRow(means);
  return text;
}

nlohmann::ordered_json ToJson(const std::vector<EvaluatedRun>& runs, const EvaluationSettings& settings,
                              const std::optional<JointEvaluation>& joint) {
  const std::vector<Figure> figures = FiguresOf(runs);
  nlohmann::ordered_json json;
  json["alignment"] = ToString(settings.alignment);
  json["common_alignment"] = settings.common_alignment;
  if (joint) {
    json["joint"] = {{"matched_poses", joint->num_pairs},
                     {"ate_se2_rmse_m", joint->ate_rmse},
                     {"ate_se2_median_m", joint->ate_median},
                     {"ate_se2_max_m", joint->ate_max}};
  }
  json["max_time_difference_s"] = settings.association.max_time_difference;
  json["max_interpolation_gap_s"] = settings.association.max_interpolation_gap;
  if (runs.front().map) {
    json["map_tolerance_m"] = settings.map.tolerance;
    json["map_beyond_is_unknown"] = settings.map.beyond_is_unknown;
  }
  for (const EvaluatedRun& run : runs) json["runs"].push_back(RunToJson(run, figures));
  for (const Figure& figure : figures) {
    nlohmann::ordered_json& entry = json["summary"][figure.key];
    if (const std::optional<RunSummary> summary = Summarize(runs, figure)) {
      entry["runs"] = summary->num_runs;
      entry["mean"] = summary->mean;
      entry["half_width_95"] = NumberOrNull(summary->half_width);
    }
  }
  return json;
}

}  // namespace arborslam
