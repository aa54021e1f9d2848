#ifndef ARBORSLAM_APPS_COMMON_PROGRESS_BAR_H_
#define ARBORSLAM_APPS_COMMON_PROGRESS_BAR_H_

#include <cstddef>
#include <functional>
#include <optional>
#include <ostream>
#include <string>

namespace arborslam {

/// True if stderr is a terminal, so that a progress bar is of use there.
bool StderrIsTerminal();

/// How far a run over scans has come, on one line that is redrawn in place at most ten times a second: the share done,
/// scans a second since the start and the time left; without a total only the count and the rate. The line is erased at
/// the end, also when an exception ends the run. Use from one thread.
class ProgressBar {
 public:
  /// A clock that never goes back [s].
  using Clock = std::function<double()>;

  /// @param stream  where the line is drawn, usually std::cerr; must outlive the bar.
  /// @param total   how many scans there will be, where it is known.
  /// @param enabled false: draw nothing. Programs pass `StderrIsTerminal() && !FLAGS_quiet`.
  ProgressBar(std::ostream& stream, std::optional<size_t> total, bool enabled);
  /// The same, with the time told by `clock`.
  ProgressBar(std::ostream& stream, std::optional<size_t> total, bool enabled, Clock clock);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Tells that `num_done` scans are done, counted from the start.
  void Update(size_t num_done);

  /// Erases the line. Print other lines only after this; a later `Update` draws it anew.
  void Clear();

 private:
  std::string Line(size_t num_done, double elapsed) const;

  std::ostream& stream_;
  const std::optional<size_t> total_;
  const bool enabled_;
  const Clock clock_;
  const double start_;
  std::optional<double> last_drawn_;
  bool is_visible_ = false;
};

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_COMMON_PROGRESS_BAR_H_
