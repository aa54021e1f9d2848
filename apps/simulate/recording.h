#ifndef ARBORSLAM_APPS_SIMULATE_RECORDING_H_
#define ARBORSLAM_APPS_SIMULATE_RECORDING_H_

#include <cstddef>
#include <filesystem>
#include <functional>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// Of a sweep's file: four float32 a point as in the KITTI data sets, or binary PCD with the points' times.
enum class SweepFormat { kBin, kPcd };

/// Writes the recording of `run` into `folder`, which must exist: clouds/000000.bin (or .pcd) and so on,
/// timestamps.txt, ground_truth.tum, gt_map.pgm and gt_map.yaml, controls.csv. Calls `progress` with the number of
/// sweeps written. Throws `UserError` when a file cannot be written, or when clouds/ holds what is not of this
/// recording.
void WriteRecording(const SimulatedRun& run, const std::filesystem::path& folder, SweepFormat format,
                    const std::function<void(size_t)>& progress);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_SIMULATE_RECORDING_H_
