#ifndef ARBORSLAM_CORE_IO_G2O_H_
#define ARBORSLAM_CORE_IO_G2O_H_

#include <Eigen/Core>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/geometry/se2.h"

namespace arborslam {

/// A planar pose graph.
struct PoseGraph2 {
  /// A measured pose of vertex `to` seen from vertex `from`.
  struct Edge {
    int from = 0;
    int to = 0;
    SE2 measurement;  ///< T_from_to [m, rad].
    /// Of (x, y, theta) in the right frame as SE2 defines it, [1/m^2, 1/(m rad), 1/rad^2]; g2o's own convention.
    Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  };

  std::map<int, SE2> vertices;  ///< T_map_vertex by id [m, rad].
  std::vector<Edge> edges;
  std::set<int> fixed;  ///< Vertices whose poses are given for certain.
};

/// True for a file that is meant as a graph in g2o text format: it is called *.g2o or its first record is one of g2o's,
/// in the plane or in space (`VERTEX_...`, `EDGE_...`, `FIX`). False for what cannot be read.
bool IsG2oFile(const std::string& path);

/// Reads a graph in g2o text format: `VERTEX_SE2 id x y theta`, `EDGE_SE2 from to x y theta I11 I12 I13 I22 I23 I33`,
/// `FIX id ...`. Throws `UserError` naming the line for another record, a wrong number of columns, a value that is not
/// finite, a coordinate beyond 1e9 m, an information beyond 1e15, a vertex id that is negative or given twice, an edge
/// from a vertex to itself, an edge or `FIX` that names a vertex which is nowhere in the file, and an information
/// matrix that is not positive definite.
PoseGraph2 ReadG2o(const std::string& path);

/// Writes `graph` in g2o text format; every number reads back as the same double. Throws `UserError` when the file
/// cannot be written.
void WriteG2o(const std::string& path, const PoseGraph2& graph);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_G2O_H_
