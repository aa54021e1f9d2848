#ifndef ARBORSLAM_FRONTEND_PROJECTION_GROUND_MODEL_H_
#define ARBORSLAM_FRONTEND_PROJECTION_GROUND_MODEL_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
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

  // In one register: Eigen puts what is made of single numbers together in memory, which costs a stall.
  using Quadruple = float __attribute__((vector_size(4 * sizeof(float))));

  static constexpr int kStride = kNodes + 2;  // Around the nodes lies a frame of zeros.

  // Index of a node, from 0 on along either edge.
  static size_t NodeAt(int column, int row) { return static_cast<size_t>((row + 1) * kStride + column + 1); }
  // The surface through what `Build` made of the returns, row by row until it is steady.
  void Smooth();

  // Where a coordinate lies between the nodes [nodes], held within the grid.
  static float ToNodes(float coordinate);
  // Bilinear, `u` and `v` being the shares of the way from `node` to its neighbours.
  static float Interpolate(const float* node, float u, float v);

  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();
  float lidar_height_ = 0.0f;
  // For every node, and 0 for the frame. A node's height is pull + share * (the sum of its neighbours' heights), or
  // share_alone * (that sum) if its returns have no say.
  std::vector<float> heights_;  // [m]
  std::vector<float> lows_;     // [m], what the returns say.
  std::vector<float> pulls_;
  std::vector<float> shares_;
  std::vector<float> shares_alone_;
  std::vector<float> ranges_;  // [m], from the lidar.
  std::vector<float> num_neighbours_;
  std::vector<std::vector<float>> returns_;  // Heights [m] of the lowest returns around each node.
  // Of the ground returns of each sample cell, and their number: half of the returns each.
  std::array<std::vector<Quadruple>, 2> sums_;
  std::vector<GroundSample> samples_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_GROUND_MODEL_H_
