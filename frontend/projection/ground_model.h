#ifndef ARBORSLAM_FRONTEND_PROJECTION_GROUND_MODEL_H_
#define ARBORSLAM_FRONTEND_PROJECTION_GROUND_MODEL_H_

#include <Eigen/Core>
#include <vector>

#include "core/sensor/ground_sample.h"
#include "frontend/projection/ground_fit.h"

namespace arborslam {

/// Turns the lidar frame upright: rows are the axes of `base`, of which z is `normal` and x has the lidar's heading.
Eigen::Matrix3f LevelRotation(const Eigen::Vector3f& normal);

/// The height of uneven ground around the lidar, over the plane of a ground fit: a surface on a grid, held to the low
/// returns where there are any, to its neighbours, and, weakly, to the plane. In the frame that the fit levels: x, y as
/// `LevelRotation` turns them, z = 0 on the plane.
class GroundModel {
 public:
  GroundModel();

  /// The surface through `lowest_returns` [m, lidar frame]. A return far above what its surroundings make likely (a
  /// hedge that hides its ground) has no say.
  void Build(const std::vector<Eigen::Vector3f>& lowest_returns, const GroundFit& fit);

  /// [m] over the fitted plane, bilinear between the nodes; beyond the grid that of its border.
  float HeightAt(float x, float y) const;

  /// For every point [m, lidar frame] its height [m] over the surface; and the means of those returns, cell by cell,
  /// that lie on it.
  void Measure(const std::vector<Eigen::Vector3f>& points, std::vector<float>* heights);

  /// In the lidar frame, as of the last `Measure`.
  const std::vector<GroundSample>& samples() const { return samples_; }

  static constexpr float kReach = 18.0f;  ///< [m], half the edge of the grid.

 private:
  static constexpr float kNodeSpacing = 1.5f;  // [m]
  static constexpr int kNodes = 25;            // Along an edge.
  static constexpr int kSampleCells = 36;      // Along an edge, of 1 m.

  struct Node {
    float low = 0.0f;     // [m], what the returns say.
    float weight = 0.0f;  // 0: no returns.
  };

  // Where a coordinate lies between the nodes [nodes], held within the grid.
  static float ToNodes(float coordinate);
  // Bilinear, `u` and `v` being the shares of the way from `node` to its neighbours.
  static float Interpolate(const float* node, float u, float v);

  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();
  float lidar_height_ = 0.0f;
  std::vector<Node> nodes_;
  std::vector<float> node_ranges_;           // [m], from the lidar.
  std::vector<float> heights_;               // [m], of the nodes.
  std::vector<std::vector<float>> returns_;  // Heights [m] of the lowest returns around each node.
  std::vector<Eigen::Vector4f> sums_;        // Of the ground returns of each sample cell, and their number.
  std::vector<GroundSample> samples_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_GROUND_MODEL_H_
