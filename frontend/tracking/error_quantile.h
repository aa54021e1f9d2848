#ifndef ARBORSLAM_FRONTEND_TRACKING_ERROR_QUANTILE_H_
#define ARBORSLAM_FRONTEND_TRACKING_ERROR_QUANTILE_H_

#include <deque>
#include <optional>

namespace arborslam {

/// How far something errs, by its last 200 errors. Single gross ones do not count: it is their 95 % quantile that does.
class ErrorQuantile {
 public:
  /// Takes an error, of either sign.
  void Add(double error);

  /// The standard deviation of normal errors with the same quantile, times `safety`: errors of successive steps are not
  /// independent. Nothing while there are less than 30.
  std::optional<double> Sigma(double safety) const;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(amounts_);
  }

 private:
  std::deque<double> amounts_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_ERROR_QUANTILE_H_
