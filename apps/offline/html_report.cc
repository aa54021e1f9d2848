#include "apps/offline/html_report.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "apps/common/version.h"
#include "apps/offline/html_text.h"
#include "apps/offline/map_picture.h"
#include "apps/offline/report_template.h"
#include "apps/offline/run_figures.h"
#include "core/evaluation/alignment.h"
#include "core/io/png.h"

namespace arborslam {
namespace {

using Json = nlohmann::ordered_json;

// Of longer runs the charts show every n-th scan, so that the file stays small.
constexpr size_t kMaxScans = 40000;
// Longer tables are cut.
constexpr size_t kMaxRows = 10000;
// [pixels], a larger map is reduced.
constexpr int kMaxMapSide = 3000;
// [m], by which rotations and translations are made comparable.
constexpr double kLeverArm = 5.0;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// `value` in units of `unit`, rounded: short, and exact enough to be drawn. Null if it is not finite.
Json Rounded(double value, double unit) {
  const double rounded = std::round(value / unit);
  if (!(std::abs(rounded) < 1e15)) return nullptr;
  return static_cast<int64_t>(rounded);
}

// Texts that recur, each once.
class Texts {
 public:
  size_t IndexOf(const std::string& text) {
    const auto [found, is_new] = index_.emplace(text, list_.size());
    if (is_new) list_.push_back(text);
    return found->second;
  }
  const std::vector<std::string>& list() const { return list_; }

 private:
  std::map<std::string, size_t> index_;
  std::vector<std::string> list_;
};

// How a scan is drawn; the letters are those of report.js.
char Fate(const ScanResult& scan) {
  if (scan.status == ScanStatus::kSkipped) return 'k';
  if (scan.status == ScanStatus::kPredicted) {
    switch (scan.match.verdict) {
      case MatchVerdict::kPoor:
        return 'p';
      case MatchVerdict::kAmbiguous:
        return 'b';
      case MatchVerdict::kTooFewPoints:
        return 'f';
      default:
        return 'r';
    }
  }
  if (!IsUsable(scan.match.verdict)) return 'i';
  if (scan.match.verdict == MatchVerdict::kDegenerate) return 'd';
  return scan.is_keyframe && !scan.is_inserted ? 's' : 'a';
}

bool WasScored(const ScanResult& scan) {
  return scan.status != ScanStatus::kSkipped && scan.match.verdict != MatchVerdict::kTooFewPoints;
}

// What a degenerate match leaves open: the bearing [rad] off the base's x axis, or not finite if it is the heading or
// more than one direction.
double UnknownBearing(const MatchResult& match) {
  if (match.verdict != MatchVerdict::kDegenerate || match.num_degenerate != 1) return kNone;
  const Eigen::DiagonalMatrix<double, 3> scale(1.0, 1.0, 1.0 / kLeverArm);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scale * match.information * scale);
  const Eigen::Vector3d weakest = solver.eigenvectors().col(0);
  if (weakest.head<2>().norm() < std::abs(weakest.z())) return kNone;
  return std::atan2(weakest.y(), weakest.x());
}

std::vector<const StampedPose3*> PosesOfScans(const RunRecord& record, const Trajectory3& trajectory) {
  std::vector<const StampedPose3*> poses(record.scans.size(), nullptr);
  size_t next = 0;
  for (size_t i = 0; i < record.scans.size() && next < trajectory.poses.size(); ++i) {
    const ScanResult& scan = record.scans[i];
    if (scan.status == ScanStatus::kSkipped || scan.stamp != trajectory.poses[next].stamp) continue;
    poses[i] = &trajectory.poses[next++];
  }
  return poses;
}

// The record's scans as columns, with one entry for every scan that is shown.
class ScanColumns {
 public:
  explicit ScanColumns(const ReportInput& input)
      : record_(input.record),
        poses_(PosesOfScans(input.record, input.trajectory)),
        odometry_(PosesOfScans(input.record, input.odometry)) {
    const size_t stride = (record_.scans.size() + kMaxScans - 1) / kMaxScans;
    for (size_t i = 0; i < record_.scans.size(); i += stride) shown_.push_back(i);
  }

  // The optimised pose of scan `index`, or null.
  const StampedPose3* Pose(size_t index) const { return poses_[index]; }

  Json ToJson() const {
    Json columns;
    columns["index"] = shown_;
    columns["t_ms"] = Column(1e-3, [this](size_t i) { return record_.scans[i].stamp - record_.scans[0].stamp; });
    std::string fates, flags;
    for (const size_t i : shown_) {
      fates += Fate(record_.scans[i]);
      const ScanResult& scan = record_.scans[i];
      flags += static_cast<char>('0' + (scan.is_keyframe ? 1 : 0) + (scan.searched_wide ? 2 : 0) +
                                 (scan.has_ground ? 0 : 4));
    }
    columns["fate"] = fates;
    columns["flags"] = flags;
    columns["score_um"] =
        Column(1e-6, [this](size_t i) { return WasScored(record_.scans[i]) ? record_.scans[i].match.score : kNone; });
    columns["inliers_permille"] = Column(
        1e-3, [this](size_t i) { return WasScored(record_.scans[i]) ? record_.scans[i].match.inlier_ratio : kNone; });
    columns["points"] = Column(1.0, [this](size_t i) { return record_.scans[i].match.num_points; });
    if (std::any_of(record_.scans.begin(), record_.scans.end(),
                    [](const ScanResult& scan) { return scan.num_moving > 0; })) {
      columns["moving"] = Column(1.0, [this](size_t i) { return record_.scans[i].num_moving; });
    }
    columns["bearing_mrad"] = Column(1e-3, [this](size_t i) { return UnknownBearing(record_.scans[i].match); });
    AddPoses(&columns);
    AddErrors(&columns);
    Json stages = Json::array();
    for (const StageField& field : StageFields()) {
      stages.push_back(Column(1e-6, [&](size_t i) { return record_.scans[i].*field.time_ms / 1000.0; }));
    }
    columns["stages_us"] = stages;
    return columns;
  }

 private:
  template <class Value>
  Json Column(double unit, const Value& value) const {
    Json column = Json::array();
    for (const size_t i : shown_) column.push_back(Rounded(static_cast<double>(value(i)), unit));
    return column;
  }

  template <class Value>
  Json PoseColumn(const std::vector<const StampedPose3*>& poses, double unit, const Value& value) const {
    return Column(unit, [&](size_t i) { return poses[i] != nullptr ? value(*poses[i]) : kNone; });
  }

  void AddPoses(Json* columns) const {
    const auto x = [](const StampedPose3& pose) { return pose.position.x(); };
    const auto y = [](const StampedPose3& pose) { return pose.position.y(); };
    const auto z = [](const StampedPose3& pose) { return pose.position.z(); };
    const auto up = [](const StampedPose3& pose) -> Eigen::Vector3d {
      return pose.orientation.conjugate() * Eigen::Vector3d::UnitZ();
    };
    const auto roll = [&](const StampedPose3& pose) { return std::atan2(up(pose).y(), up(pose).z()); };
    const auto pitch = [&](const StampedPose3& pose) { return std::asin(std::clamp(-up(pose).x(), -1.0, 1.0)); };
    (*columns)["x_mm"] = PoseColumn(poses_, 1e-3, x);
    (*columns)["y_mm"] = PoseColumn(poses_, 1e-3, y);
    (*columns)["heading_mrad"] =
        PoseColumn(poses_, 1e-3, [](const StampedPose3& pose) { return Heading(pose.orientation); });
    (*columns)["odometry_x_mm"] = PoseColumn(odometry_, 1e-3, x);
    (*columns)["odometry_y_mm"] = PoseColumn(odometry_, 1e-3, y);
    const bool is_planar = std::all_of(poses_.begin(), poses_.end(), [&](const StampedPose3* pose) {
      return pose == nullptr || std::abs(z(*pose)) + std::abs(up(*pose).x()) + std::abs(up(*pose).y()) < 1e-6;
    });
    if (is_planar) return;
    (*columns)["z_mm"] = PoseColumn(poses_, 1e-3, z);
    (*columns)["roll_mrad"] = PoseColumn(poses_, 1e-3, roll);
    (*columns)["pitch_mrad"] = PoseColumn(poses_, 1e-3, pitch);
  }

  // Errors and reference in the map frame, by the stamps of the pairs.
  void AddErrors(Json* columns) const {
    if (!record_.errors) return;
    const auto by_stamp = [](const TrajectoryEvaluation& evaluation, const auto& value) {
      std::map<double, double> values;
      for (size_t i = 0; i < evaluation.aligned_pairs.size(); ++i) {
        values[evaluation.aligned_pairs[i].estimate.stamp] = value(i);
      }
      return values;
    };
    const auto column = [this](double unit, const std::map<double, double>& values) {
      return Column(unit, [&](size_t i) {
        const auto found = values.find(record_.scans[i].stamp);
        return found != values.end() && record_.scans[i].status != ScanStatus::kSkipped ? found->second : kNone;
      });
    };
    const TrajectoryEvaluation& trajectory = record_.errors->trajectory;
    const TrajectoryEvaluation& odometry = record_.errors->odometry;
    const Eigen::Isometry3d T_map_reference = trajectory.T_reference_estimate.inverse();
    const auto reference = [&](size_t i) -> Eigen::Vector3d {
      return T_map_reference *
             (trajectory.aligned_pairs[i].reference.position - trajectory.z_offset * Eigen::Vector3d::UnitZ());
    };
    (*columns)["error_um"] =
        column(1e-6, by_stamp(trajectory, [&](size_t i) { return trajectory.position_errors[i]; }));
    (*columns)["odometry_error_um"] =
        column(1e-6, by_stamp(odometry, [&](size_t i) { return odometry.position_errors[i]; }));
    (*columns)["reference_x_mm"] = column(1e-3, by_stamp(trajectory, [&](size_t i) { return reference(i).x(); }));
    (*columns)["reference_y_mm"] = column(1e-3, by_stamp(trajectory, [&](size_t i) { return reference(i).y(); }));
    if (!trajectory.metrics.z_rms) return;
    (*columns)["reference_z_mm"] = column(1e-3, by_stamp(trajectory, [&](size_t i) { return reference(i).z(); }));
  }

  const RunRecord& record_;
  std::vector<const StampedPose3*> poses_;
  std::vector<const StampedPose3*> odometry_;
  std::vector<size_t> shown_;  // Indices of the scans that are shown.
};

Json RunFacts(const ReportInput& input) {
  const RunRecord& record = input.record;
  const RunCounts counts = CountRun(record);
  double path = 0.0;
  for (size_t i = 1; i < input.trajectory.poses.size(); ++i) {
    path += (input.trajectory.poses[i].position - input.trajectory.poses[i - 1].position).head<2>().norm();
  }
  return {{"program", std::string("arborslam_offline ") + kVersion},
          {"input", record.input},
          {"threads", record.num_threads},
          {"odometry_only", record.odometry_only},
          {"interrupted", record.is_interrupted},
          {"state", ToString(record.verdict.state)},
          {"verdict", "result " + TextOf(record.verdict)},
          {"notices", record.notices},
          {"first_stamp_s", record.scans.empty() ? 0.0 : record.scans.front().stamp},
          {"path_m", path},
          {"submaps", record.num_submaps},
          {"peak_memory_mib", PeakMemoryMib()},
          {"scans",
           {{"read", record.scans.size()},
            {"matched", counts.matched},
            {"rejected", counts.rejected},
            {"skipped", counts.skipped},
            {"spoilt", counts.spoilt},
            {"keyframes", counts.keyframes},
            {"searched_wide", counts.searched_wide},
            {"degenerate", counts.degenerate}}}};
}

Json Times(const RunRecord& record) {
  const auto row = [](const char* key, const char* name, const std::vector<double>& times) {
    return Json{{"key", key},
                {"name", name},
                {"median_ms", Percentile(times, 0.5)},
                {"p95_ms", Percentile(times, 0.95)},
                {"max_ms", Percentile(times, 1.0)}};
  };
  Json stages = Json::array();
  for (const StageField& field : StageFields()) {
    stages.push_back(row(field.key, field.name, OverPosedScans(record, field.time_ms)));
  }
  return {{"stages", stages},
          {"total", row("total", "all stages of a scan", OverPosedScans(record, &TotalMs))},
          {"loop_search_ms", record.finish.loop_ms},
          {"optimization_ms", record.finish.optimize_ms},
          {"map_refinement_ms", record.finish.refine_ms},
          {"terrain_ms", record.finish.terrain_ms},
          {"second_pass_ms", record.maps_ms},
          {"run_ms", 1000.0 * record.wall_seconds}};
}

Json Errors(const RunErrors& errors) {
  Json figures = Json::array();
  for (const MetricField& field : MetricFields()) {
    const auto of = [&](const TrajectoryEvaluation& evaluation) -> Json {
      const std::optional<double> value = field.value(evaluation.metrics);
      return value ? Json(*value) : Json(nullptr);
    };
    figures.push_back({{"name", field.name},
                       {"unit", field.unit},
                       {"trajectory", of(errors.trajectory)},
                       {"odometry", of(errors.odometry)}});
  }
  Json json{{"alignment", ToString(errors.trajectory.alignment)},
            {"unmatched_poses", errors.unmatched_poses},
            {"path_m", errors.trajectory.path_length()},
            {"ate_rmse_m", errors.trajectory.metrics.ate_rmse},
            {"odometry_ate_rmse_m", errors.odometry.metrics.ate_rmse},
            {"end_error_m", errors.trajectory.metrics.end_error},
            {"figures", figures}};
  if (errors.loops) json["false_loops"] = errors.loops->num_false;
  return json;
}

// Rows [index, t_ms, fate, reason, points, score_um, inliers_permille] of the scans that were not used.
Json UnusedScans(const RunRecord& record, Texts* texts) {
  Json rows = Json::array();
  size_t total = 0;
  for (size_t i = 0; i < record.scans.size(); ++i) {
    const ScanResult& scan = record.scans[i];
    if (scan.status == ScanStatus::kMatched || ++total > kMaxRows) continue;
    rows.push_back({i, Rounded(scan.stamp - record.scans[0].stamp, 1e-3), std::string(1, Fate(scan)),
                    texts->IndexOf(scan.reason), scan.match.num_points,
                    Rounded(WasScored(scan) ? scan.match.score : kNone, 1e-6),
                    Rounded(WasScored(scan) ? scan.match.inlier_ratio : kNone, 1e-3)});
  }
  return {{"total", total}, {"rows", rows}};
}

// The axial mean, in [-pi/2, pi/2], of the bearings that a stretch leaves unknown.
double MeanUnknownBearing(const RunRecord& record, const DegenerateStretch& stretch) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (size_t i = stretch.first; i <= stretch.last; ++i) {
    const double bearing = UnknownBearing(record.scans[i].match);
    if (std::isfinite(bearing)) sum += Eigen::Vector2d(std::cos(2.0 * bearing), std::sin(2.0 * bearing));
  }
  return sum.norm() > 0.0 ? 0.5 * std::atan2(sum.y(), sum.x()) : kNone;
}

// Rows [first, last, t_ms of the first, length_mm, bearing_mrad].
Json Stretches(const RunRecord& record) {
  Json rows = Json::array();
  const std::vector<DegenerateStretch> stretches = DegenerateStretches(record);
  for (const DegenerateStretch& stretch : stretches) {
    if (rows.size() == kMaxRows) break;
    rows.push_back({stretch.first, stretch.last,
                    Rounded(record.scans[stretch.first].stamp - record.scans[0].stamp, 1e-3),
                    Rounded(stretch.length_m, 1e-3), Rounded(MeanUnknownBearing(record, stretch), 1e-3)});
  }
  return {{"total", stretches.size()}, {"rows", rows}};
}

// Loops and submaps, with keyframes told as scans.
class LoopTable {
 public:
  LoopTable(const ReportInput& input, const ScanColumns& scans) : input_(input), scans_(scans) {
    for (size_t i = 0; i < input.record.scans.size(); ++i) {
      if (input.record.scans[i].is_keyframe) scan_of_keyframe_.push_back(i);
    }
    for (const PoseGraphSummary& pass : input.record.finish.refinements) {
      for (const Constraint& loop : pass.dropped_loops) dropped_.emplace(loop.from.value, loop.to.value);
    }
  }

  // Rows [scan, keyframe, submap, state, reason, score_um, inliers_permille, second_um, x, y, x, y]; the state is
  // accepted, refused or dropped again; positions [mm] are the scan's and the one in the submap that is nearest to it.
  Json Loops(Texts* texts) const {
    Json rows = Json::array();
    for (const LoopCandidate& loop : input_.record.finish.loops) {
      if (rows.size() == kMaxRows) break;
      const std::optional<Eigen::Vector2d> from = Position(loop.keyframe);
      const std::optional<Eigen::Vector2d> to = from ? NearestIn(loop.submap, *from) : std::nullopt;
      if (!to) continue;
      const bool is_dropped = loop.reason == kContradictsOthers ||
                              (loop.accepted && dropped_.count({loop.submap.value, loop.keyframe.value}) > 0);
      const std::string reason = is_dropped ? kContradictsOthers : loop.reason;
      const char* state = is_dropped ? "dropped" : loop.accepted ? "accepted" : "refused";
      rows.push_back({Scan(loop.keyframe), loop.keyframe.value, loop.submap.value, state, texts->IndexOf(reason),
                      Rounded(loop.match.score, 1e-6), Rounded(loop.match.inlier_ratio, 1e-3),
                      Rounded(loop.match.second_score, 1e-6), Rounded(from->x(), 1e-3), Rounded(from->y(), 1e-3),
                      Rounded(to->x(), 1e-3), Rounded(to->y(), 1e-3)});
    }
    return {{"total", input_.record.finish.loops.size()}, {"rows", rows}};
  }

  // Per submap [id, first scan, last scan].
  Json Submaps() const {
    Json rows = Json::array();
    for (const Submap& submap : input_.submaps) {
      if (submap.keyframes.empty() || !Position(submap.keyframes.back())) continue;
      rows.push_back({submap.id.value, Scan(submap.keyframes.front()), Scan(submap.keyframes.back())});
    }
    return rows;
  }

 private:
  size_t Scan(KeyframeId id) const { return scan_of_keyframe_[static_cast<size_t>(id.value)]; }

  std::optional<Eigen::Vector2d> Position(KeyframeId id) const {
    if (id.value < 0 || static_cast<size_t>(id.value) >= scan_of_keyframe_.size()) return std::nullopt;
    const StampedPose3* const pose = scans_.Pose(Scan(id));
    if (pose == nullptr) return std::nullopt;
    return pose->position.head<2>();
  }

  std::optional<Eigen::Vector2d> NearestIn(SubmapId id, const Eigen::Vector2d& point) const {
    std::optional<Eigen::Vector2d> nearest;
    for (const Submap& submap : input_.submaps) {
      if (!(submap.id == id)) continue;
      for (const KeyframeId keyframe : submap.keyframes) {
        const std::optional<Eigen::Vector2d> position = Position(keyframe);
        if (position && (!nearest || (*position - point).norm() < (*nearest - point).norm())) nearest = position;
      }
    }
    return nearest;
  }

  const ReportInput& input_;
  const ScanColumns& scans_;
  std::vector<size_t> scan_of_keyframe_;
  std::set<std::pair<int, int>> dropped_;  // Submap, keyframe; by refinement passes.
};

// JSON for a script element: no '<' in it can end the element or begin a comment.
std::string ForScript(const Json& json) {
  // What is not UTF-8, which names of files need not be, is replaced.
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      result += "\\u003c";
    } else {
      result += c;
    }
  }
  return result;
}

// The template with its places, "@NAME@", filled; what is filled in is not looked at again.
std::string Fill(std::string_view html, const std::map<std::string_view, std::string>& places) {
  std::string result;
  size_t begin = 0;
  while (begin < html.size()) {
    const size_t at = html.find('@', begin);
    const size_t end = at == std::string_view::npos ? at : html.find('@', at + 1);
    if (end == std::string_view::npos) break;
    const auto place = places.find(html.substr(at + 1, end - at - 1));
    result += html.substr(begin, at - begin);
    if (place != places.end()) {
      result += place->second;
      begin = end + 1;
    } else {
      result += '@';
      begin = at + 1;
    }
  }
  return result += html.substr(begin);
}

}  // namespace

std::string HtmlReport(const ReportInput& input) {
  const RunRecord& record = input.record;
  const ScanColumns scans(input);
  const LoopTable loops(input, scans);
  Texts texts;
  Json data;
  data["run"] = RunFacts(input);
  data["times"] = Times(record);
  if (record.errors) data["errors"] = Errors(*record.errors);
  Json gates = Json::array();
  for (const ScoreGate& gate : input.score_gates) gates.push_back({{"score_m", gate.score}, {"label", gate.label}});
  data["gates"] = gates;
  data["scans"] = scans.ToJson();
  data["unused"] = UnusedScans(record, &texts);
  data["stretches"] = Stretches(record);
  data["loops"] = loops.Loops(&texts);
  data["submaps"] = loops.Submaps();
  data["texts"] = texts.list();
  data["config"] = input.effective_config;

  std::string image;
  if (input.map != nullptr) {
    const MapBackdrop backdrop = DrawBackdrop(*input.map, kMaxMapSide);
    data["map"] = {{"metres_per_pixel", backdrop.metres_per_pixel},
                   {"left_m", backdrop.left},
                   {"top_m", backdrop.top},
                   {"width", backdrop.image.width},
                   {"height", backdrop.image.height},
                   {"unknown_shade", kUnknownShade}};
    image = "<img id=\"map-image\" alt=\"\" hidden src=\"data:image/png;base64," + Base64(EncodePng(backdrop.image)) +
            "\">";
  }
  const std::string name = std::filesystem::path(record.input).filename().string();
  return Fill(kReportHtml, {{"TITLE", ForHtml(name.empty() ? record.input : name)},
                            {"STYLE", std::string(kReportCss)},
                            {"MAP", image},
                            {"DATA", ForScript(data)},
                            {"SCRIPT", std::string(kReportJs)}});
}

}  // namespace arborslam
