#ifndef ARBORSLAM_FRONTEND_PROJECTION_CANOPY_HEIGHT_H_
#define ARBORSLAM_FRONTEND_PROJECTION_CANOPY_HEIGHT_H_

#include <Eigen/Core>
#include <array>
#include <vector>

namespace arborslam {

/// Estimates the mean canopy height of paper eq. 5 from what stands above the ground.
class CanopyHeight {
 public:
  static constexpr float kLeast = 0.6f;    ///< [m]
  static constexpr float kMost = 2.0f;     ///< [m]
  static constexpr float kInitial = 1.0f;  ///< [m], before anything was seen.

  /// Takes in the returns of a sweep.
  /// @param points  [m, lidar frame].
  /// @param heights [m], of each over the ground.
  void Add(const std::vector<Eigen::Vector3f>& points, const std::vector<float>& heights);

  /// [m], in [kLeast, kMost].
  float Get() const;

  /// What it remembers of the sweeps.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(returns_, num_sweeps_);
  }

 private:
  static constexpr int kBins = 40;
  static constexpr float kBinHeight = 0.1f;  // [m]

  std::array<float, kBins> returns_{};  // By height, a running mean over sweeps.
  int num_sweeps_ = 0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_CANOPY_HEIGHT_H_
