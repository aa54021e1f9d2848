#ifndef ARBORSLAM_CORE_EVALUATION_MAP_METRICS_H_
#define ARBORSLAM_CORE_EVALUATION_MAP_METRICS_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/io/map_io.h"

namespace arborslam {

/// How an estimated map compares with a reference (Nazate-Burgos et al. 2026, section on metrics), cell by cell of the
/// reference's grid.
///
/// R are the occupied cells of the reference. E are the cells of the reference's grid, continued beyond its edges, that
/// the estimate's occupied cells cover: those whose centre lies in an occupied cell of the moved estimate, and those
/// that hold the centre of one (so that no cell of a finer estimate is lost). Two cells are near each other if their
/// centres are no further apart than the tolerance (Euclidean; at tolerance 0 a cell is near itself only).
///
///   right    a cell of E near one of R, and a cell of R near one of E
///   FP       a cell of E that is not near any of R; beyond the edges of the reference, too
///   FN       a cell of R that is not near any of E, whether the estimate calls it free or unknown
///   TN       a cell that is free in the reference and, at its centre, free in the estimate, and is not in E
///   neither  any other: unknown on either side. A cell of E that is not near R but is unknown in the reference is no
///            mistake that could be proved (`unjudged`). With `beyond_is_unknown` the same goes for one beyond the
///            edges.
///
///   precision    cells of E that are right / (cells of E that are right + FP)
///   sensitivity  cells of R that are right / (cells of R that are right + FN) = cells of R that are right / R
///   accuracy     (right + TN) / (right + TN + FP + FN), where a cell of both E and R is one
///
/// At tolerance 0 these are the usual TP/(TP+FP), TP/(TP+FN) and (TP+TN)/(TP+TN+FP+FN), TP being the cells of both.
struct MapMetrics {
  size_t estimated_occupied = 0;    ///< Cells of E.
  size_t reference_occupied = 0;    ///< Cells of R, more than 0.
  size_t estimated_right = 0;       ///< Cells of E that are right: the TP of the precision.
  size_t reference_found = 0;       ///< Cells of R that are right: the TP of the sensitivity.
  size_t right = 0;                 ///< Cells of E or R that are right: the TP of the accuracy.
  size_t false_positives = 0;       ///< FP.
  size_t false_negatives = 0;       ///< FN.
  size_t true_negatives = 0;        ///< TN.
  size_t outside = 0;               ///< Cells of E beyond the edges of the reference; they are in the others, too.
  size_t unjudged = 0;              ///< Cells of E that are neither right nor FP.
  std::optional<double> precision;  ///< In [0, 1]; absent when E has no cell that is right or FP.
  double sensitivity = 0.0;         ///< In [0, 1].
  double accuracy = 0.0;            ///< In [0, 1].
};

/// What counts in a comparison of maps.
struct MapComparisonOptions {
  double tolerance = 0.0;  ///< [m], >= 0, at most 150 cells of the reference.
  /// Whether the reference leaves open what lies beyond its edges, as one does that was cut out of a larger world;
  /// otherwise there is nothing there.
  bool beyond_is_unknown = false;
};

/// Compares `estimate` with `reference` after it was moved by `T_reference_estimate`. Cells of 100 are occupied, of 0
/// free, all others unknown, as `ReadMapServer` gives them. A point that lies on the border of two cells belongs to the
/// one of greater coordinates.
/// @param place names the two maps in errors, such as by their files.
/// Throws `UserError` when the reference has no occupied cell, the tolerance is not in its range, or the estimate's
/// cells are more than 100 times as long as the reference's.
MapMetrics CompareMaps(const GridImage& estimate, const GridImage& reference, const SE2& T_reference_estimate,
                       const MapComparisonOptions& options, const std::string& place);

/// How a figure of `MapMetrics` is presented.
struct MapMetricField {
  const char* key;      ///< For machines: "map_precision".
  const char* name;     ///< For people: "map precision".
  const char* heading;  ///< For narrow columns: "prec".
  std::optional<double> (*value)(const MapMetrics&);
};

/// Precision, sensitivity and accuracy.
const std::vector<MapMetricField>& MapMetricFields();

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_EVALUATION_MAP_METRICS_H_
