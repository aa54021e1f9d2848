#ifndef ARBORSLAM_CORE_IO_SWEEP_FOLDER_OPTIONS_H_
#define ARBORSLAM_CORE_IO_SWEEP_FOLDER_OPTIONS_H_

#include <Eigen/Geometry>
#include <optional>
#include <string>

namespace arborslam {

/// What the files of a folder of sweeps do not say themselves.
struct SweepFolderOptions {
  /// The moment of a sweep that its stamp names: "start", "middle" or "end".
  std::string stamp = "start";
  double sweep_duration = 0.0;  ///< [s], how long a sweep lasts; 0: found out, see `SweepFolder`.
  /// How the lidar is mounted: "x y z roll pitch yaw" [m, deg] (`ParsePose`); empty: found from the sweeps.
  std::string T_base_lidar = {};
  /// The frame of the points: "lidar", or "base" where they were moved there by `T_base_lidar`.
  std::string frame = "lidar";

  /// Of `.bin` files: "auto", found from the sweeps, or as "4 x float32", "5 x float32", "3 x float64, big-endian"
  /// (`BinLayout::Name`).
  std::string layout = "auto";

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("stamp", stamp);
    visit("sweep_duration", sweep_duration);
    visit("T_base_lidar", T_base_lidar);
    visit("frame", frame);
    visit("layout", layout);
  }
};

/// The transform T_a_b of "x y z roll pitch yaw" [m, deg], with blanks or commas between, as URDF has it: translation
/// x, y, z and rotation Rz(yaw) Ry(pitch) Rx(roll). Nothing where the text is anything else.
std::optional<Eigen::Isometry3d> ParsePose(const std::string& text);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SWEEP_FOLDER_OPTIONS_H_
