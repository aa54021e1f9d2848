#include "apps/common/error_json.h"

#include <nlohmann/json.hpp>
#include <optional>

namespace arborslam {

nlohmann::ordered_json ErrorsJson(AlignmentKind alignment, const TrajectoryMetrics& metrics) {
  nlohmann::ordered_json errors{{"alignment", ToString(alignment)}};
  for (const MetricField& field : MetricFields()) {
    const std::optional<double> value = field.value(metrics);
    if (value) errors[field.key] = *value;
  }
  return errors;
}

}  // namespace arborslam
