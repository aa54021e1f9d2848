#ifndef ARBORSLAM_APPS_SIMULATE_RECORDING_H_
#define ARBORSLAM_APPS_SIMULATE_RECORDING_H_

#include <cstddef>
#include <filesystem>
#include <functional>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// Writes the recording of `run` into `folder`, which must exist: clouds/000000.bin and so on, timestamps.txt,
/// ground_truth.tum, gt_map.pgm and gt_map.yaml, controls.csv. Calls `progress` with the number of sweeps written.
/// Throws `UserError`.
void WriteRecording(const SimulatedRun& run, const std::filesystem::path& folder,
                    const std::function<void(size_t)>& progress);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_SIMULATE_RECORDING_H_
