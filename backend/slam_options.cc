#include "backend/slam_options.h"

#include "core/config/validation.h"

namespace arborslam {

std::string WindowOptions::Validate() const {
  if (num_keyframes < 2 || num_keyframes > 1000) {
    return Violation("num_keyframes", num_keyframes, "lie in [2, 1000]");
  }
  return "";
}

}  // namespace arborslam
