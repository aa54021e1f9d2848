#ifndef ARBORSLAM_BACKEND_LOOP_PLACE_DESCRIPTOR_H_
#define ARBORSLAM_BACKEND_LOOP_PLACE_DESCRIPTOR_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// What a place looks like in the plane, so that places can be compared without knowing anything about where they lie:
/// how the trunks and posts around it are arranged, by ring of distance and sector of bearing (after Kim and Kim 2018,
/// "Scan Context", with how full a bin is in place of the greatest height). Turning the robot shifts the sectors and
/// changes nothing else. Bins spill into their neighbours, so that a step to the side changes little.
struct PlaceDescriptor {
  static constexpr int kNumRings = 20;
  static constexpr int kNumSectors = 60;
  static constexpr double kSectorWidth = 6.283185307179586 / kNumSectors;  ///< [rad]

  using Bins = Eigen::Matrix<float, kNumRings, kNumSectors>;
  using RingKey = Eigen::Matrix<float, kNumRings, 1>;

  Bins bins = Bins::Zero();  ///< Of norm 1, or 0 where there is nothing to see. Sector 0 begins at bearing -pi.
  RingKey ring_key = RingKey::Zero();  ///< Mean of each ring of `bins`: does not change with the heading.
};

/// Describes the place of a scan.
/// @param points    [m], base frame, in any order.
/// @param max_range [m], > 0; farther points are left out.
PlaceDescriptor DescribePlace(const std::vector<Eigen::Vector2f>& points, double max_range);

/// How alike two places are at the relative heading at which they are most alike.
struct PlaceSimilarity {
  double value = 0.0;  ///< Cosine, in [0, 1]; 0 where one of them has nothing to see.
  double yaw = 0.0;    ///< [rad] in [-pi, pi), heading of `query` in the frame of `place`, to a sector's width.
};

PlaceSimilarity ComparePlaces(const PlaceDescriptor& query, const PlaceDescriptor& place);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_PLACE_DESCRIPTOR_H_
