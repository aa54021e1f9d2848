#ifndef ARBORSLAM_CORE_IO_SWEEP_FOLDER_OPTIONS_H_
#define ARBORSLAM_CORE_IO_SWEEP_FOLDER_OPTIONS_H_

#include <string>

namespace arborslam {

/// What the files of a folder of sweeps do not say themselves.
struct SweepFolderOptions {
  /// The moment of a sweep that its stamp names: "start", "middle" or "end".
  std::string stamp = "start";
  double sweep_duration = 0.0;  ///< [s], how long a sweep lasts; 0: found out, see `SweepFolder`.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("stamp", stamp);
    visit("sweep_duration", sweep_duration);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SWEEP_FOLDER_OPTIONS_H_
