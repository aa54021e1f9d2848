#ifndef ARBORSLAM_APPS_OFFLINE_OFFLINE_OPTIONS_H_
#define ARBORSLAM_APPS_OFFLINE_OFFLINE_OPTIONS_H_

#include "backend/graph/graph_smoother.h"
#include "backend/slam_options.h"
#include "backend/store/memory_options.h"
#include "core/io/sweep_folder_options.h"
#include "core/map/cloud_options.h"
#include "core/map/fine_map.h"

namespace arborslam {

/// All sections of arborslam_offline's configuration.
struct OfflineOptions {
  SweepFolderOptions input;
  SlamOptions slam;
  FineMapOptions map;
  CloudOptions cloud;
  SmoothingOptions smoothing;
  MemoryOptions memory;

  /// Calls `visit(name, options)` for every section, in the order of the pipeline.
  template <class Visitor>
  void VisitSections(Visitor&& visit) {
    visit("input", input);
    slam.VisitSections(visit);
    visit("map", map);
    visit("cloud", cloud);
    visit("smoothing", smoothing);
    visit("memory", memory);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_OFFLINE_OPTIONS_H_
