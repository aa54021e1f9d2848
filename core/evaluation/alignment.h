#ifndef ARBORSLAM_CORE_EVALUATION_ALIGNMENT_H_
#define ARBORSLAM_CORE_EVALUATION_ALIGNMENT_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/association.h"
#include "core/geometry/se2.h"

namespace arborslam {

/// How an estimate is moved onto its reference before the two are compared.
enum class AlignmentKind {
  kNone,    ///< Not at all: both are in the same frame.
  kOrigin,  ///< In the plane, so that the first poses coincide (the paper's way).
  kSe2,     ///< In the plane, so that the positions fit best.
  kSe3,     ///< In space, so that the positions fit best.
};

/// "none", "origin", "se2" or "se3".
std::string ToString(AlignmentKind kind);

/// The kind that `ToString` gives `name` for; nothing if there is none.
std::optional<AlignmentKind> ParseAlignmentKind(const std::string& name);

/// True if poses aligned so are compared in space, false if only x, y and the heading about z count. The method's poses
/// are planar, so a reference's altitude must not weigh on them unless asked for.
inline bool IsSpatial(AlignmentKind kind) { return kind == AlignmentKind::kSe3; }

/// The heading [rad] in [-pi, pi) of a body: the direction of its x axis seen from above (z up).
double Heading(const Eigen::Quaterniond& orientation);

/// The planar rigid motion T_to_from that minimises sum |to_i - T * from_i|^2, without scale (Umeyama 1991, for two
/// dimensions, where the optimal rotation has a closed form).
/// Where the points leave the rotation open (one point; one set coincident; perfectly balanced sets), it is 0 and the
/// centroids coincide. Collinear points determine it.
/// @param from,to 2 x n [m], n >= 1; column i of one belongs to column i of the other. Throws `std::invalid_argument`.
SE2 UmeyamaSe2(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to);

/// The rigid motion T_to_from that minimises sum |to_i - T * from_i|^2, without scale and never a reflection (Umeyama
/// 1991, eq. 40-42, with c = 1).
/// Where the points leave the rotation open it is chosen so: none if one set is coincident; for collinear points the
/// one that maps line to line and keeps the plane through line and z axis vertical (no roll about the line).
/// @param from,to 3 x n [m], n >= 1; column i of one belongs to column i of the other. Throws `std::invalid_argument`.
Eigen::Isometry3d UmeyamaSe3(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// T_reference_estimate: the motion that carries the estimate's frame onto the reference's.
///
/// `kOrigin` makes the first pair coincide and uses no other. A trajectory that gives positions only (its orientations
/// are the identity) is taken to have its first heading along +x, as the Pullally positions do.
/// @param pairs at least one. Throws `std::invalid_argument`.
Eigen::Isometry3d Align(const std::vector<PosePair>& pairs, AlignmentKind kind);

/// `pose` of the estimate, moved by `T_reference_estimate`.
StampedPose3 Transform(const Eigen::Isometry3d& T_reference_estimate, const StampedPose3& pose);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_EVALUATION_ALIGNMENT_H_
