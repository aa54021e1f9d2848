#ifndef ARBORSLAM_CORE_EVALUATION_TRAJECTORY_PLOT_H_
#define ARBORSLAM_CORE_EVALUATION_TRAJECTORY_PLOT_H_

#include <string>

#include "core/evaluation/trajectory_metrics.h"

namespace arborslam {

/// What a plot is called.
struct TrajectoryPlotLabels {
  std::string title;  ///< The run; the ATE and the alignment are added. Shortened where it is too long.
};

/// Draws `evaluation` as the bytes of a PNG: above, the aligned estimate on the reference from above (x to the right, y
/// up, equal scales [m]); below, the position error [m] along the reference's path [m]. Throws `UserError` when cairo
/// fails, for lack of memory for one.
std::string RenderTrajectoryPlot(const TrajectoryEvaluation& evaluation, const TrajectoryPlotLabels& labels);

/// Writes the plot to the PNG file `path`, whole or not at all. Throws `UserError`.
void WriteTrajectoryPlot(const std::string& path, const TrajectoryEvaluation& evaluation,
                         const TrajectoryPlotLabels& labels);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_EVALUATION_TRAJECTORY_PLOT_H_
