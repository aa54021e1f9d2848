#ifndef ARBORSLAM_FRONTEND_MOUNTING_LEVELLED_SOURCE_H_
#define ARBORSLAM_FRONTEND_MOUNTING_LEVELLED_SOURCE_H_

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/io/scan_source.h"
#include "core/io/sweep_folder_options.h"

namespace arborslam {

/// A recording whose sweeps are given in an upright frame with the lidar at its origin, whatever frame they are
/// recorded in: of a lidar that leans, lies on its side or hangs upside down, or of points in the robot's frame, whose
/// origin is on the ground. The mounting comes from `SweepFolderOptions::T_base_lidar`, else from the first sweeps
/// (`EstimateMounting`). Sweeps of a usual mounting, and scans in a plane, stay as they are, to the bit; so do those
/// whose ground was not found. What was found and done is in the notices.
///
/// Poses of a levelled recording are those of the upright frame: at the lidar's origin, z up, x with the heading of
/// the points' x axis (`UprightRotation`), or of base where `T_base_lidar` is given. The same recording and options
/// give the same frame each time. Up to 20 sweeps are read ahead at opening.
class LevelledSource : public ScanSource {
 public:
  /// `options` must be valid. An error of `source` within the sweeps read ahead is thrown when their turn comes.
  LevelledSource(std::unique_ptr<ScanSource> source, const SweepFolderOptions& options);

  std::optional<Scan> Next() override;
  std::optional<size_t> NumScans() const override { return source_->NumScans(); }
  const std::vector<std::string>& Notices() const override { return notices_; }

 private:
  // Fills ahead_ and error_; returns some of the sweeps, spread over those read, or none of a planar recording.
  std::vector<LidarSweep> ReadAhead();
  void FindMounting(std::vector<LidarSweep> sweeps);
  void TakeMounting(const SweepFolderOptions& options, std::vector<LidarSweep> sweeps);
  void Level(LidarSweep* sweep) const;

  std::unique_ptr<ScanSource> source_;
  std::vector<std::string> notices_;
  bool is_levelling_ = false;
  // p_upright = R p + t.
  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f translation_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f spin_axis_ = Eigen::Vector3f::UnitZ();  // As of `LidarSweep`.
  std::deque<Scan> ahead_;
  std::exception_ptr error_;  // After the scans of ahead_.
};

/// Opens the recording at `path` as `OpenScanSource` does, levelled.
std::unique_ptr<ScanSource> OpenLevelledSource(const std::string& path, const SweepFolderOptions& options = {});

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MOUNTING_LEVELLED_SOURCE_H_
