#ifndef ARBORSLAM_FRONTEND_PROJECTION_SWEEP_PROJECTION_H_
#define ARBORSLAM_FRONTEND_PROJECTION_SWEEP_PROJECTION_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/sensor/planar_scan.h"

namespace arborslam {

/// Which returns of a 3D lidar stand for what is there, and how they become planar points.
struct SweepProjectionOptions {
  double min_range = 0.5;       ///< [m], nearer returns are the robot itself.
  double max_range = 20.0;      ///< [m], farther returns are left out: tilt and terrain make them unsure.
  double max_bearing = 3.1416;  ///< [rad], returns from farther behind than this are left out: an operator walks there.
  double ground_margin = 0.18;  ///< [m], returns less than this above the ground are ground or grass,
  double ground_growth = 0.008;  ///< [m] more per m of range.
  /// [m], of paper eq. 5: returns above it are foliage and left out (eq. 6). 0: found out from the sweeps.
  double mean_canopy_height = 0.0;
  double column_width = 0.0;    ///< [deg], bearings this close are one column; 0: the sensor's own.
  double column_depth = 0.1;    ///< [m], returns of a column that lie this close in range become one point.
  double point_spacing = 0.03;  ///< [m], points of neighbouring columns closer than this become one.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("min_range", min_range);
    visit("max_range", max_range);
    visit("max_bearing", max_bearing);
    visit("ground_margin", ground_margin);
    visit("ground_growth", ground_growth);
    visit("mean_canopy_height", mean_canopy_height);
    visit("column_width", column_width);
    visit("column_depth", column_depth);
    visit("point_spacing", point_spacing);
  }
};

/// Paper eq. 5: lambda exp(-lambda z) with lambda = ln 2 / mean_canopy_height for z >= 0, else 0.
double HeightLikelihood(double z, double mean_canopy_height);

/// Paper eq. 6: beta_h = 0.5 ln 2 / mean_canopy_height. Since lambda exp(-lambda z) falls to lambda / 2 where z is the
/// mean canopy height, keeping what is at least this likely is keeping 0 <= z <= mean_canopy_height.
double MinHeightLikelihood(double mean_canopy_height);

/// Reduces sweeps to planar scans. Keeps its memory from one sweep to the next.
class SweepProjection {
 public:
  /// `options` must be valid.
  explicit SweepProjection(const SweepProjectionOptions& options);

  /// What `Project` reads of a sweep.
  struct Input {
    const std::vector<Eigen::Vector3f>* points;  ///< [m, lidar frame].
    const std::vector<float>* heights;           ///< [m], of each point over the ground.
    float lidar_height;                          ///< [m], of the lidar over the ground below it.
    float mean_canopy_height;                    ///< [m]
    float column_width;                          ///< [rad]
    /// As of `PointPhases`; null or empty: not known.
    const std::vector<float>* phases = nullptr;
  };

  /// The planar points of a sweep in the frame that `R_base_lidar` turns upright, by bearing: what is solid between
  /// the ground and the mean canopy height.
  ///
  /// Eq. 6 leaves trunks and the leaves that hang beside them. They are told apart by range: neighbouring beams that
  /// meet something solid, be it as thin as a vine, end at one range, those that enter leaves at random ranges, other
  /// ones in every sweep. So returns are compared with those of the columns within some centimetres on either side
  /// and of about the same height; with n of m returns at its range, a return has a solidity of (n - 1) / (m + 1).
  /// Where little is solid, the most solid of the rest is kept as well; where very much is, the least solid is left
  /// out.
  ///
  /// Returns of one column that lie over one another become one point, and so do points of neighbouring columns closer
  /// than the point spacing; `weights` says of how many returns each is the mean, and `phases` when one of them was
  /// measured (the mean of the sweep's first and last moment would be its middle).
  ///
  /// `free_ends` has one ray for every sector of bearing in which the ground, or what stands on it, was seen from so
  /// low that nothing, not even a cone, can stand before it unseen; it ends before the nearest thing that may be solid.
  /// The rays to the points say nothing of the kind: they may pass over low things.
  PlanarScan Project(const Input& input, const Eigen::Matrix3f& R_base_lidar);

 private:
  struct Return {
    float x;
    float y;
    float range;
    float phase;
    uint32_t bin;  // Layer by layer, column by column.
  };
  // A return from within the ground margin, in a list of those of its column.
  struct LowReturn {
    Return value;
    uint32_t next;     // Of low_.
    uint32_t run = 0;  // Of low_runs_.
  };
  // Such returns side by side.
  struct LowRun {
    float range;  // [m], of the last one.
    uint32_t first_column;
    uint32_t last_column;
  };
  // Returns of a bin at about one range.
  struct Cluster {
    Eigen::Vector2f sum;
    float range;   // [m], mean.
    float weight;  // Number of returns.
    float phase;   // Of one of them.
    float solidity;
    uint32_t bin;
    uint32_t column;
  };
  // Clusters of neighbouring columns that are one planar point.
  struct Point {
    Eigen::Vector2f sum;
    Eigen::Vector2f first;
    float weight;
    float phase;
    uint32_t column;
  };

  // Fills kept_, bin_ends_ (with the numbers of returns, one bin late) and seen_.
  void Select(const Input& input, const Eigen::Matrix3f& R_base_lidar);
  // Adds what is low but narrow, and of one range from column to column, to what is kept: the foot of a trunk that
  // leaves hide above. The ground, where its height is misjudged, is wide, and grass has other ranges in every column.
  void KeepLowThings(float column_width);
  // Fills sorted_, ranges_, bin_ends_ and clusters_.
  void MakeClusters();
  // How sure it is that `cluster` is something solid, in [0, 1).
  float Solidity(const Cluster& cluster, float column_width) const;
  // Fills solid_ and nearest_.
  void FindSolid(float column_width);
  // Makes what lies beside something solid of two columns at least, one column on and at its range, solid too: the
  // edges of trunks, which have fewer neighbours, and without which trunks would seem the thinner the farther off they
  // are.
  void KeepEdges(float column_width, float least);
  // Fills points_.
  void MakePoints();
  void AddFreeRays(PlanarScan* scan) const;

  SweepProjectionOptions options_;
  size_t num_columns_ = 0;
  std::vector<Return> kept_;
  std::vector<LowReturn> low_;
  std::vector<uint32_t> low_of_column_;  // For each column, the head of its list in low_.
  std::vector<LowRun> low_runs_;
  std::vector<Return> sorted_;  // By bin, then by range.
  std::vector<float> ranges_;   // [m], of sorted_; and some more.
  std::vector<uint32_t> bin_ends_;
  std::vector<Eigen::Vector2f> directions_;  // Unit vectors, of the sectors' middles.
  std::vector<uint64_t> seen_;               // For each sector, the steps of range that were seen down to the ground.
  std::vector<float> first_;                 // [m], for each sector, the nearest return.
  std::vector<float> nearest_;               // [m], for each sector, the nearest thing that may be solid.
  std::vector<Cluster> clusters_;
  std::vector<float> solidities_;
  std::vector<Cluster> solid_;
  std::vector<size_t> edges_;  // Of clusters_.
  std::vector<Point> points_;
  std::vector<uint32_t> open_;  // Points that the last column began or went on with.
  std::vector<uint32_t> still_open_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_SWEEP_PROJECTION_H_
