#ifndef ARBORSLAM_BACKEND_TERRAIN_SCAN_TILTS_H_
#define ARBORSLAM_BACKEND_TERRAIN_SCAN_TILTS_H_

#include <cstddef>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/posed_scan.h"
#include "backend/terrain/terrain_smoother.h"

namespace arborslam {

/// Smooths the tilts and heights of all sweeps of a map over the terrain that they saw together (`SmoothTerrain`), and
/// stands the map upright (`EstimateLevel`). Planar poses, those of `graph`, stay as they are; so do planar scans.
void SmoothTilts(const TerrainOptions& options, const PoseGraph& graph, std::vector<PosedScan>* scans);

/// Lifts and leans the sweeps behind the first `num_known` as one, so that the ground which both saw lies at one
/// height: z = 0 is where each run began. Does nothing where nothing was seen by both, and to planar scans.
void LayOnKnownGround(const TerrainOptions& options, const PoseGraph& graph, size_t num_known,
                      std::vector<PosedScan>* scans);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_TERRAIN_SCAN_TILTS_H_
