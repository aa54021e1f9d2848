#ifndef ARBORSLAM_APPS_SESSION_SESSION_OUTPUTS_H_
#define ARBORSLAM_APPS_SESSION_SESSION_OUTPUTS_H_

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/offline/loaded_session.h"

namespace arborslam {

/// The files that `WriteSessionOutputs` writes of a session of so many recordings: trajectory.tum, or trajectory_1.tum
/// and so on of more than one, graph.g2o, map.yaml, map.pgm and map.png.
std::vector<std::string> SessionOutputNames(size_t num_recordings);

/// Writes what a session, `Completed` and not empty, comes to into `folder`, which exists. Throws `UserError`.
void WriteSessionOutputs(const std::filesystem::path& folder, const LoadedSession& session);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_SESSION_SESSION_OUTPUTS_H_
