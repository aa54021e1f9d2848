#include "apps/evaluate/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace arborslam {
namespace {

constexpr size_t kLabelWidth = 6;
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

std::string Number(const std::optional<double>& value) {
  if (!value) return kAbsent;
  char text[64];
  // What rounds to 0 has no sign.
  std::snprintf(text, sizeof(text), "%.4f", std::abs(*value) < 0.5e-4 ? 0.0 : *value);
  return text;
}

std::string PadLeft(const std::string& text, size_t width) {
  return std::string(width - std::min(width, text.size()), ' ') + text;
}

std::string PadRight(const std::string& text, size_t width) {
  return text + std::string(width - std::min(width, text.size()), ' ');
}

std::string MatchedText(const EvaluatedRun& run) {
  const AssociationResult& association = run.association;
  return std::to_string(association.pairs.size()) +
         " pairs; without a partner: " + std::to_string(association.unmatched_estimate) + " of the estimate, " +
         std::to_string(association.unmatched_reference) + " of the reference";
}

std::optional<RunSummary> Summarize(const std::vector<EvaluatedRun>& runs, const MetricField& field) {
  std::vector<double> values;
  for (const EvaluatedRun& run : runs) {
    if (const std::optional<double> value = field.value(run.evaluation.metrics)) values.push_back(*value);
  }
  return SummarizeRuns(values);
}

std::string FormatOneRun(const EvaluatedRun& run) {
  std::string text;
  text += "estimate     " + run.estimate_path + "\n";
  text += "reference    " + run.reference_path + "\n";
  text += "matched      " + MatchedText(run) + "\n";
  text += "path length  " + Number(run.evaluation.path_length()) + " m\n";
  text += "alignment    " + Describe(run.evaluation.alignment) + "\n\n";
  size_t name_width = 0;
  for (const MetricField& field : MetricFields()) name_width = std::max(name_width, std::string(field.name).size());
  for (const MetricField& field : MetricFields()) {
    const std::optional<double> value = field.value(run.evaluation.metrics);
    text +=
        PadRight(field.name, name_width) + PadLeft(Number(value), 12) + (value ? std::string(" ") + field.unit : "");
    text += "\n";
  }
  return text;
}

std::string FormatRow(const std::string& label, const std::vector<std::string>& cells) {
  std::string row = PadRight(label, kLabelWidth);
  for (const std::string& cell : cells) row += " " + PadLeft(cell, kCellWidth);
  return row + "\n";
}

std::string FormatManyRuns(const std::vector<EvaluatedRun>& runs) {
  std::string text = "alignment  " + Describe(runs.front().evaluation.alignment) + "\n";
  for (size_t i = 0; i < runs.size(); ++i) {
    text += "run " + std::to_string(i + 1) + "      " + runs[i].estimate_path + " against " + runs[i].reference_path +
            ": " + MatchedText(runs[i]) + "\n";
  }
  text += "\n";
  std::vector<std::string> headings;
  std::vector<std::string> units;
  std::vector<std::string> means;
  std::vector<std::string> half_widths;
  for (const MetricField& field : MetricFields()) {
    headings.push_back(field.heading);
    units.push_back(std::string("[") + field.unit + "]");
    const std::optional<RunSummary> summary = Summarize(runs, field);
    means.push_back(summary ? Number(summary->mean) : kAbsent);
    half_widths.push_back(summary ? Number(summary->half_width) : kAbsent);
  }
  text += FormatRow("run", headings) + FormatRow("", units);
  for (size_t i = 0; i < runs.size(); ++i) {
    std::vector<std::string> cells;
    for (const MetricField& field : MetricFields()) cells.push_back(Number(field.value(runs[i].evaluation.metrics)));
    text += FormatRow(std::to_string(i + 1), cells);
  }
  text += FormatRow("mean", means) + FormatRow("+-", half_widths);
  text += "\n+- is 1.96 sd / sqrt(N). ";
  text += "e: mean error, RMS: its root mean square; p: position, th: heading, dp: step length, dth: step rotation.\n";
  text += "ATE, ATE_med, ATE_max: RMSE, median and maximum after SE(2) alignment.\n";
  return text;
}

nlohmann::ordered_json NumberOrNull(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json RunToJson(const EvaluatedRun& run) {
  nlohmann::ordered_json json;
  json["estimate"] = run.estimate_path;
  json["reference"] = run.reference_path;
  json["matched_poses"] = run.association.pairs.size();
  json["unmatched_estimate_poses"] = run.association.unmatched_estimate;
  json["unmatched_reference_poses"] = run.association.unmatched_reference;
  json["path_length_m"] = run.evaluation.path_length();
  const Eigen::Matrix4d T = run.evaluation.T_reference_estimate.matrix();
  for (Eigen::Index row = 0; row < 4; ++row) {
    json["T_reference_estimate"].push_back({T(row, 0), T(row, 1), T(row, 2), T(row, 3)});
  }
  for (const MetricField& field : MetricFields()) json[field.key] = NumberOrNull(field.value(run.evaluation.metrics));
  return json;
}

}  // namespace

std::string FormatTable(const std::vector<EvaluatedRun>& runs) {
  return runs.size() == 1 ? FormatOneRun(runs.front()) : FormatManyRuns(runs);
}

nlohmann::ordered_json ToJson(const std::vector<EvaluatedRun>& runs, const AssociationOptions& options) {
  nlohmann::ordered_json json;
  json["alignment"] = ToString(runs.front().evaluation.alignment);
  json["max_time_difference_s"] = options.max_time_difference;
  json["max_interpolation_gap_s"] = options.max_interpolation_gap;
  for (const EvaluatedRun& run : runs) json["runs"].push_back(RunToJson(run));
  for (const MetricField& field : MetricFields()) {
    nlohmann::ordered_json& entry = json["summary"][field.key];
    if (const std::optional<RunSummary> summary = Summarize(runs, field)) {
      entry["runs"] = summary->num_runs;
      entry["mean"] = summary->mean;
      entry["half_width_95"] = NumberOrNull(summary->half_width);
    }
  }
  return json;
}

}  // namespace arborslam
