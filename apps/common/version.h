#ifndef ARBORSLAM_APPS_COMMON_VERSION_H_
#define ARBORSLAM_APPS_COMMON_VERSION_H_

namespace arborslam {

/// What `--version` of every program prints; a test holds it to the version in CMakeLists.txt.
constexpr char kVersion[] = "0.1.0";

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_COMMON_VERSION_H_
