#ifndef ARBORSLAM_CORE_EVALUATION_RELATIONS_H_
#define ARBORSLAM_CORE_EVALUATION_RELATIONS_H_

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "core/sensor/trajectory3.h"

namespace arborslam {

/// What is known for certain of two poses of a run: the later seen from the earlier, or the other way about.
struct Relation {
  double from_stamp = 0.0;                                      ///< [s]
  double to_stamp = 0.0;                                        ///< [s]
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();  ///< [m]
};

/// Reads relations as Kuemmerle et al. 2009 publish them, lines `t1 t2 x y z roll pitch yaw` [s, m, rad]: the pose at
/// t2 seen from the one at t1; '#' before a comment. Angles are those of yaw, pitch, roll (Z-Y'-X''). Throws
/// `UserError` naming the line for another number of columns, a value that is not finite and a coordinate beyond 1e9 m;
/// and for a file without relations.
std::vector<Relation> ReadRelations(const std::string& path);

/// How well a trajectory keeps to relations.
struct RelationMetrics {
  size_t num_matched = 0;         ///< Relations both of whose poses were found.
  size_t num_relations = 0;       ///< All that there are.
  double translation_mean = 0.0;  ///< [m], of the norm of the error's translation,
  double translation_sd = 0.0;    ///< [m], its standard deviation over the relations (divided by their number),
  double translation_max = 0.0;   ///< [m], and the greatest one.
  double rotation_mean = 0.0;     ///< [rad], of the angle of the error's rotation, likewise.
  double rotation_sd = 0.0;       ///< [rad]
  double rotation_max = 0.0;      ///< [rad]
};

/// The metric of Kuemmerle et al., "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27, 2009: of each
/// relation d* and the same relative pose d of the estimate, the error d*^-1 d, as the mean and the standard deviation
/// of the amounts of its translation and its rotation. No alignment is involved.
/// @param max_time_difference [s], >= 0, between a relation's stamp and the nearest pose of the estimate.
/// @param place names the files in errors. Throws `UserError` when no relation can be matched.
RelationMetrics EvaluateRelations(const Trajectory3& estimate, const std::vector<Relation>& relations,
                                  double max_time_difference, const std::string& place);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_EVALUATION_RELATIONS_H_
