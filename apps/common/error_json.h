#ifndef ARBORSLAM_APPS_COMMON_ERROR_JSON_H_
#define ARBORSLAM_APPS_COMMON_ERROR_JSON_H_

#include <nlohmann/json_fwd.hpp>

#include "core/evaluation/trajectory_metrics.h"

namespace arborslam {

/// The errors of a trajectory as summary.json has them: the alignment, and every metric that there is by its key.
nlohmann::ordered_json ErrorsJson(AlignmentKind alignment, const TrajectoryMetrics& metrics);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_COMMON_ERROR_JSON_H_
