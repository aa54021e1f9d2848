#ifndef ARBORSLAM_CORE_IO_VERTEX_POSES_H_
#define ARBORSLAM_CORE_IO_VERTEX_POSES_H_

#include <string>

#include "core/sensor/trajectory3.h"

namespace arborslam {

/// Reads the true poses of a pose graph's vertices; a pose's stamp is the vertex's id. The format is told from the
/// content:
///
///   g2o        `VERTEX_SE2 id x y theta`, see `ReadG2o`
///   4 columns  `id x y theta` [m, rad]
///   3 columns  `x y theta` of vertices 0, 1, 2 and so on
///   8 columns  TUM text, see `ReadTrajectory`
///
/// Throws `UserError` naming the line when the file cannot be read, a value is not finite, the number of columns is
/// none of these or changes, an id comes twice, or there is no pose at all.
Trajectory3 ReadVertexPoses(const std::string& path);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_VERTEX_POSES_H_
