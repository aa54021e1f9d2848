#include "core/io/sweep_folder_options.h"

#include "core/config/validation.h"

namespace arborslam {

std::string SweepFolderOptions::Validate() const {
  if (stamp != "start" && stamp != "middle" && stamp != "end") {
    return Violation("stamp", stamp, "be start, middle or end");
  }
  if (!(sweep_duration >= 0.0 && sweep_duration <= 10.0)) {
    return Violation("sweep_duration", sweep_duration, "lie in [0, 10] s (0: found out)");
  }
  return "";
}

}  // namespace arborslam
