#ifndef ARBORSLAM_FRONTEND_TRACKING_WHEEL_ODOMETRY_H_
#define ARBORSLAM_FRONTEND_TRACKING_WHEEL_ODOMETRY_H_

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "core/geometry/se2.h"
#include "frontend/tracking/error_quantile.h"

namespace arborslam {

/// How wheel odometry is used and how far it errs, as known before the run: standard deviations of a step grow with
/// its length and turn (after the sampling model of Thrun, Burgard and Fox 2005, section 5.4).
struct OdometryOptions {
  bool enabled = true;                 ///< Use it where a recording has it.
  double translation_sigma = 0.01;     ///< [m], of any step: odometry may be read some time before the scan.
  double rotation_sigma = 0.005;       ///< [rad], likewise.
  double translation_per_metre = 0.1;  ///< [m per m] of way.
  double translation_per_turn = 0.05;  ///< [m per rad] of turn.
  double rotation_per_metre = 0.03;    ///< [rad per m] of way.
  double rotation_per_turn = 0.1;      ///< [rad per rad] of turn.
  bool learn_sigma = true;             ///< Find out how far it really errs; false: as far as that.
  /// [m], the greatest path in a submap of a run with wheels: corridors bend a map little by little, and only short
  /// pieces of it are true as rigid parts.
  double submap_length = 15.0;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("enabled", enabled);
    visit("translation_sigma", translation_sigma);
    visit("rotation_sigma", rotation_sigma);
    visit("translation_per_metre", translation_per_metre);
    visit("translation_per_turn", translation_per_turn);
    visit("rotation_per_metre", rotation_per_metre);
    visit("rotation_per_turn", rotation_per_turn);
    visit("learn_sigma", learn_sigma);
    visit("submap_length", submap_length);
  }
};

/// A step as the wheels measured it.
struct OdometryStep {
  SE2 motion;             ///< From the earlier scan to the later one, in the lidar's frame.
  Eigen::Vector3d sigma;  ///< [m, m, rad], standard deviations of its x, y and theta.
};

/// The wheels' say on how the robot moved, and how far that errs, learned from the run itself: errors are compared with
/// what the options have them be, and all of that is stretched to fit. For one thread.
class WheelOdometry {
 public:
  explicit WheelOdometry(const OdometryOptions& options);

  /// The step from the last scan, and from the last keyframe, to a scan where the wheels say that the lidar is at
  /// `pose`; nothing where scan or predecessor have no odometry, it is not used, or it jumps by over 100 m.
  std::optional<OdometryStep> SinceScan(const std::optional<SE2>& pose) const { return Since(last_scan_, pose); }
  std::optional<OdometryStep> SinceKeyframe(const std::optional<SE2>& pose) const {
    return Since(last_keyframe_, pose);
  }

  /// Takes a scan's odometry, if it has any, as what the next ones' steps begin at.
  void Commit(const std::optional<SE2>& pose, bool is_keyframe);

  /// Takes how far a step erred, if the match knows better than the step's sigma.
  /// @param matched      the same motion by the match.
  /// @param information  of `matched`, (x, y, theta) in its own frame [1/m^2, 1/rad^2].
  void Learn(const OdometryStep& step, const SE2& matched, const Eigen::Matrix3d& information);

  /// True if the run has had odometry, also if the options say not to use it.
  bool has_odometry() const { return has_odometry_; }

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(has_odometry_, last_scan_, last_keyframe_, stretch_, errors_);
  }

 private:
  std::optional<OdometryStep> Since(const std::optional<SE2>& from, const std::optional<SE2>& pose) const;

  OdometryOptions options_;
  bool has_odometry_ = false;
  std::optional<SE2> last_scan_;
  std::optional<SE2> last_keyframe_;
  Eigen::Vector3d stretch_ = Eigen::Vector3d::Ones();  // Of the options' standard deviations of x, y, theta.
  std::array<ErrorQuantile, 3> errors_;                // [options' standard deviations]
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_WHEEL_ODOMETRY_H_
