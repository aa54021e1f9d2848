#ifndef ARBORSLAM_APPS_OFFLINE_GRAPH_RUN_H_
#define ARBORSLAM_APPS_OFFLINE_GRAPH_RUN_H_

#include <filesystem>
#include <functional>
#include <string>

#include "apps/offline/offline_options.h"

namespace arborslam {

/// An existing pose graph that is to be smoothed.
struct GraphRun {
  std::string input;             ///< g2o, see `ReadG2o`.
  std::string ground_truth;      ///< See `ReadVertexPoses`; empty: none.
  std::string effective_config;  ///< YAML.
  int num_threads = 1;
  bool quiet = false;  ///< Print errors only.
};

/// Reads the graph, smooths it, and writes into a folder: graph.g2o (the vertices smoothed, without the loops that were
/// dropped), trajectory.tum (all vertices, the stamp is the id), graph.png, summary.json, report.html and
/// effective_config.yaml. What else an earlier run on a recording left there is removed. Prints a summary.
/// @param prepare_output gives the folder, proved to be writable; called when the input has been read.
/// @return the exit code. Throws `UserError`; the results may be complete but for the errors against the ground truth.
int RunOnGraph(const GraphRun& run, const OfflineOptions& options,
               const std::function<std::filesystem::path()>& prepare_output);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_GRAPH_RUN_H_
