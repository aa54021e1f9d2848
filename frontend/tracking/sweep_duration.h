#ifndef ARBORSLAM_FRONTEND_TRACKING_SWEEP_DURATION_H_
#define ARBORSLAM_FRONTEND_TRACKING_SWEEP_DURATION_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/geometry/se2.h"
#include "frontend/tracking/planar_velocity.h"

namespace arborslam {

/// How long a sweep lasts, as far as the motion tells.
struct SweepDurationEstimate {
  double seconds = 0.0;
  /// [s], standard deviation of `seconds`; infinite as long as there is no estimate.
  double standard_error = std::numeric_limits<double>::infinity();
  int num_sweeps = 0;  ///< That were compared with earlier ones.
};

/// A planar sweep, and what is known of its motion.
struct TimedSweep {
  double stamp = 0.0;                   ///< [s], of any moment that is the same in every sweep.
  std::vector<Eigen::Vector2f> points;  ///< [m, base frame], as they were deskewed.
  std::vector<float> phases;            ///< As in `PlanarScan`; sweeps without are not compared.
  PlanarVelocity deskewing;             ///< The points were deskewed with this velocity
  double deskewing_duration = 0.0;      ///< and this duration [s].
  SE2 T_odom_base;                      ///< Of the sweep's middle.
  bool is_matched = true;               ///< False: the pose is a mere prediction.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(stamp, points, phases, deskewing, deskewing_duration, T_odom_base, is_matched);
  }
};

/// Finds how long the sweeps of a recording last: a point measured at phase f of a sweep of duration d, while the lidar
/// moves with (v, w), lies (f - 1/2) d (v + w x p) from where the lidar at the sweep's middle would have seen it. A
/// wrong d thus shears a sweep, more when it turns fast, and it no longer fits those before it that had another motion
/// or saw the same thing at another phase.
///
/// For each of some candidate durations, sweeps are deskewed anew, with the velocity between their neighbours' poses,
/// and aligned with three earlier ones, about half a metre or half a radian apart; the slope G of the robust sum of
/// squared distances with d, the pose being eliminated, is summed over the run. The estimate is where the sum goes
/// through zero at the least cost, and the scatter of G between blocks of sweeps gives its standard error. Both do not
/// depend on what the sweeps were deskewed with. Sweeps that move more than usual tell most; of others few are
/// compared, and none that hardly moves. Costs some hundredths of a millisecond per sweep. For one thread.
class SweepDurationEstimator {
 public:
  /// Takes the next sweep; it is used when the one after it comes. True when there is a new estimate.
  bool Add(TimedSweep sweep);

  SweepDurationEstimate Estimate() const;

  /// The median step between the stamps of the first sweeps [s]; 0 when there is none.
  double MedianStep() const;

  /// What it remembers of the sweeps.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(latest_, references_, steps_, sum_motion_, num_motions_, num_left_out_, num_since_reference_, num_compared_,
          block_, sum_, sum_of_squares_);
    if constexpr (std::decay_t<Visitor>::kIsReading) MakeClouds();
  }

 private:
  static constexpr size_t kNumCandidates = 10;

  // A sweep as the lidar measured it.
  struct RawSweep {
    std::vector<Eigen::Vector2f> points;  // [m], in the frame in which each was measured.
    std::vector<float> phases;            // Since the middle: -1/2 to 1/2.
    PlanarVelocity velocity;
    SE2 T_odom_base;

    template <class Visitor>
    void VisitState(Visitor&& visit) {
      visit(points, phases, velocity, T_odom_base);
    }
  };
  struct CloudPoint {
    Eigen::Vector2f position;  // [m], in the frame of the last reference.
    Eigen::Vector2f shift;     // [m/s], of the position with the duration.
    int32_t next;              // In the same bucket, or -1.
  };
  // The references deskewed with one candidate, for look-up.
  struct Cloud {
    std::vector<CloudPoint> points;
    std::vector<int32_t> buckets;
  };

  // The sweep between its two neighbours, or nothing if its velocity is not known.
  std::optional<RawSweep> MakeRaw(const TimedSweep& before, const TimedSweep& sweep, const TimedSweep& after) const;
  // Whether the sweep is worth its comparison.
  bool IsChosen(const RawSweep& sweep);
  // Returns whether this was the last of a block.
  bool Compare(const RawSweep& sweep);
  void AddReference(RawSweep sweep);
  // The clouds of the references.
  void MakeClouds();
  static const CloudPoint* Nearest(const Cloud& cloud, const Eigen::Vector2f& position);

  std::deque<TimedSweep> latest_;  // Three at most.
  std::deque<RawSweep> references_;
  std::array<Cloud, kNumCandidates> clouds_;
  std::vector<double> steps_;  // [s], of the first sweeps.
  double sum_motion_ = 0.0;    // [m/s]
  int num_motions_ = 0;
  int num_left_out_ = 0;         // In a row.
  int num_since_reference_ = 0;  // Comparisons.
  int num_compared_ = 0;
  // By candidate: slopes of the present block, and the sums of the blocks and of their squares.
  std::array<double, kNumCandidates> block_{};
  std::array<double, kNumCandidates> sum_{};
  std::array<double, kNumCandidates> sum_of_squares_{};
};

/// What the duration of a sweep is, going by `estimate`, for sweeps whose stamps are `step` [s] apart. Candidates are
/// `step`, which a lidar has that measures without a pause; the periods of usual lidars, 0.05, 0.1 and 0.2 s, where at
/// least every second sweep was left out; and 0, a simulator that stops the time. The only one that lies within the
/// estimate's uncertainty is taken; when there is none, or several, the estimate itself if it is exact to 0.02 s; else
/// nothing is.
std::optional<double> DecideSweepDuration(const SweepDurationEstimate& estimate, double step);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_SWEEP_DURATION_H_
