#include "apps/offline/run_figures.h"

#include <sys/resource.h>

#include <algorithm>

namespace arborslam {

const char* ToString(ScanStatus status) {
  switch (status) {
    case ScanStatus::kMatched:
      return "matched";
    case ScanStatus::kPredicted:
      return "rejected";
    case ScanStatus::kSkipped:
      return "skipped";
  }
  return "unknown";
}

const char* ToString(PoseSource source) {
  switch (source) {
    case PoseSource::kMeasured:
      return "measured";
    case PoseSource::kInterpolated:
      return "interpolated";
    case PoseSource::kUnknown:
      return "left out";
  }
  return "unknown";
}

std::vector<size_t> PosedIndices(const RunRecord& record) {
  std::vector<size_t> indices;
  for (size_t i = 0; i < record.scans.size(); ++i) {
    if (record.scans[i].status != ScanStatus::kSkipped) indices.push_back(i);
  }
  return indices;
}

RunCounts CountRun(const RunRecord& record) {
  RunCounts counts;
  for (const ScanResult& scan : record.scans) {
    const bool is_matched = scan.status == ScanStatus::kMatched;
    counts.matched += is_matched ? 1 : 0;
    counts.rejected += scan.status == ScanStatus::kPredicted ? 1 : 0;
    counts.skipped += scan.status == ScanStatus::kSkipped ? 1 : 0;
    counts.spoilt += is_matched && scan.is_keyframe && !scan.is_inserted ? 1 : 0;
    counts.keyframes += scan.is_keyframe ? 1 : 0;
    counts.searched_wide += scan.searched_wide ? 1 : 0;
    counts.degenerate += scan.match.verdict == MatchVerdict::kDegenerate ? 1 : 0;
  }
  for (const LoopCandidate& loop : record.finish.loops) counts.loops_accepted += loop.accepted ? 1 : 0;
  return counts;
}

const std::vector<StageField>& StageFields() {
  static const std::vector<StageField> fields = {
      {"project", "reduction to planar points", &ScanResult::project_ms},
      {"match", "prediction, search, refinement", &ScanResult::match_ms},
      {"window", "smoothing and marginalisation", &ScanResult::window_ms},
      {"insert", "growing the maps", &ScanResult::insert_ms},
  };
  return fields;
}

double TotalMs(const ScanResult& scan) {
  double total = 0.0;
  for (const StageField& field : StageFields()) total += scan.*field.time_ms;
  return total;
}

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto nth = values.begin() + static_cast<ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

std::vector<DegenerateStretch> DegenerateStretches(const RunRecord& record) {
  std::vector<DegenerateStretch> stretches;
  bool is_open = false;
  for (size_t i = 0; i < record.scans.size(); ++i) {
    const ScanResult& scan = record.scans[i];
    const bool is_degenerate = scan.status != ScanStatus::kSkipped && scan.match.verdict == MatchVerdict::kDegenerate;
    if (is_degenerate && is_open) {
      DegenerateStretch& stretch = stretches.back();
      const Eigen::Vector2d from = record.scans[stretch.last].T_odom_base.translation();
      stretch.length_m += (scan.T_odom_base.translation() - from).norm();
      stretch.last = i;
    } else if (is_degenerate) {
      stretches.push_back({i, i, 0.0});
    }
    is_open = is_degenerate;
  }
  return stretches;
}

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace arborslam
