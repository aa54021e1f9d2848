#include "core/simulation/planar_orchard.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

// First of the random streams of each kind; the n-th scan uses the n-th stream after it.
enum Stream : uint64_t {
  kTrees = 0,
  kLayout = 1,
  kPoses = uint64_t{1} << 32,
  kTilts = 2 * kPoses,
  kBeams = 3 * kPoses
};

constexpr double kPostRadius = 0.05;        // [m].
constexpr double kHedgeRoughness = 0.1;     // [m].
constexpr double kBorderDistance = 2.0;     // [m] from the path to the fence.
constexpr double kFoliageAcross = 0.3;      // [m], how far leaves stand off the row.
constexpr double kMinSpoiltTilt = 0.08;     // [rad], 4.6 deg: ground at 5.6 m from 0.45 m above it.
constexpr double kMaxSpoiltTilt = 0.25;     // [rad], 14 deg: ground at 1.8 m.
constexpr double kWanderWavelength = 18.0;  // [m], about.

// How many alleys the robot walks: all, and if their number is odd also along the outside of the last row, so that the
// last pass leads back to the side of the start.
int NumPasses(const PlanarOrchardOptions& options) { return options.rows - 1 + (options.rows - 1) % 2; }

double RowLength(const PlanarOrchardOptions& options) { return (options.trees_per_row - 1) * options.tree_spacing; }

ClosedPath Serpentine(const PlanarOrchardOptions& options) {
  const double near_end = -options.headland;
  const double far_end = RowLength(options) + options.headland;
  std::vector<Eigen::Vector2d> corners = {{0.0, 0.0}};
  for (int pass = 0; pass < NumPasses(options); ++pass) {
    const double y = pass * options.row_spacing;
    if (pass > 0) corners.emplace_back(pass % 2 == 0 ? near_end : far_end, y);
    corners.emplace_back(pass % 2 == 0 ? far_end : near_end, y);
  }
  corners.emplace_back(near_end, 0.0);
  return ClosedPath(corners, options.turn_radius);
}

}  // namespace

std::string PlanarOrchardOptions::Validate() const {
  if (seed < 0) return Violation("seed", seed, "be at least 0");
  if (rows < 2 || rows > 200) return Violation("rows", rows, "lie in [2, 200]");
  if (trees_per_row < 2 || trees_per_row > 500) return Violation("trees_per_row", trees_per_row, "lie in [2, 500]");
  if (foliage_per_tree < 0 || foliage_per_tree > 20) {
    return Violation("foliage_per_tree", foliage_per_tree, "lie in [0, 20]");
  }
  if (num_scans < 0) return Violation("num_scans", num_scans, "be at least 0");

  const std::pair<const char*, double> positive[] = {{"row_spacing", row_spacing},   {"tree_spacing", tree_spacing},
                                                     {"trunk_radius", trunk_radius}, {"foliage_radius", foliage_radius},
                                                     {"headland", headland},         {"scan_period", scan_period}};
  for (const auto& [key, value] : positive) {
    if (!(value > 0.0 && value <= 1000.0)) return Violation(key, value, "lie in (0, 1000]");
  }
  const std::pair<const char*, double> not_negative[] = {{"position_jitter", position_jitter},
                                                         {"foliage_density", foliage_density},
                                                         {"fence_post_spacing", fence_post_spacing},
                                                         {"turn_radius", turn_radius},
                                                         {"wander", wander},
                                                         {"step_jitter", step_jitter},
                                                         {"sway", sway},
                                                         {"heading_jitter", heading_jitter}};
  for (const auto& [key, value] : not_negative) {
    if (!(value >= 0.0 && value <= 1000.0)) return Violation(key, value, "lie in [0, 1000]");
  }
  if (!(step >= 0.001 && step <= 10.0)) return Violation("step", step, "lie in [0.001, 10]");
  if (fence_post_spacing > 0.0 && fence_post_spacing < 0.1) {
    return Violation("fence_post_spacing", fence_post_spacing, "be 0 or at least 0.1");
  }
  if (!(radius_spread >= 0.0 && radius_spread < trunk_radius)) {
    return Violation("radius_spread", radius_spread, "lie in [0, trunk_radius)");
  }
  if (!(trunk_radius + radius_spread + position_jitter < 0.5 * row_spacing)) {
    return Violation("row_spacing", row_spacing, "leave room between trunks for the robot");
  }
  const std::pair<const char*, double> probabilities[] = {{"missing_trees", missing_trees},
                                                          {"spoilt_scans", spoilt_scans}};
  for (const auto& [key, value] : probabilities) {
    if (!(value >= 0.0 && value <= 1.0)) return Violation(key, value, "lie in [0, 1]");
  }
  return lidar.Validate();
}

PlanarOrchardOptions IdealPlanarOrchardOptions() {
  PlanarOrchardOptions options;
  options.position_jitter = 0.0;
  options.radius_spread = 0.0;
  options.missing_trees = 0.0;
  options.foliage_density = 0.0;
  options.fence_post_spacing = 0.0;
  options.hedge = false;
  options.wander = 0.0;
  options.step_jitter = 0.0;
  options.sway = 0.0;
  options.heading_jitter = 0.0;
  options.spoilt_scans = 0.0;
  options.lidar.range_noise = 0.0;
  options.lidar.range_resolution = 0.0;
  options.lidar.drop_out = 0.0;
  return options;
}

PlanarOrchard::PlanarOrchard(const PlanarOrchardOptions& options)
    : options_(options), lidar_(options.lidar), path_(Serpentine(options)) {
  const double steps_around = std::max(1.0, std::round(path_.Length() / options.step));
  step_ = path_.Length() / steps_around;
  num_scans_ = options.num_scans > 0 ? static_cast<size_t>(options.num_scans) : static_cast<size_t>(steps_around) + 1;
  Plant();
  Enclose();
}

void PlanarOrchard::Plant() {
  const PlanarOrchardOptions& o = options_;
  Random random(o.seed, kTrees);
  for (int row = 0; row < o.rows; ++row) {
    for (int tree = 0; tree < o.trees_per_row; ++tree) {
      const Eigen::Vector2d place(tree * o.tree_spacing, (row - 0.5) * o.row_spacing);
      const double dx = random.Uniform(-o.position_jitter, o.position_jitter);
      const double dy = random.Uniform(-o.position_jitter, o.position_jitter);
      const double radius = o.trunk_radius + random.Uniform(-o.radius_spread, o.radius_spread);
      const bool missing = random.Uniform() < o.missing_trees;
      if (!missing) trunks_.push_back({place + Eigen::Vector2d(dx, dy), radius});
      for (int i = 0; i < o.foliage_per_tree; ++i) {
        const double reach = i == 0 ? kFoliageAcross : 0.5 * o.tree_spacing;
        const double along = random.Uniform(-reach, reach);
        const double across = random.Uniform(-kFoliageAcross, kFoliageAcross);
        const double foliage_radius = o.foliage_radius * random.Uniform(2.0 / 3.0, 4.0 / 3.0);
        if (missing || o.foliage_density == 0.0) continue;
        world_.foliage.push_back({place + Eigen::Vector2d(along, across), foliage_radius, o.foliage_density});
      }
    }
  }
  world_.discs = trunks_;
}

void PlanarOrchard::Enclose() {
  const double last_row = (options_.rows - 1.5) * options_.row_spacing;
  const double last_pass = (NumPasses(options_) - 1) * options_.row_spacing;
  const Eigen::Vector2d low(-options_.headland - kBorderDistance, -0.5 * options_.row_spacing - kBorderDistance);
  const Eigen::Vector2d high(RowLength(options_) + options_.headland + kBorderDistance,
                             std::max(last_row, last_pass) + kBorderDistance);
  if (options_.hedge) world_.walls.push_back({{low.x(), high.y()}, high, kHedgeRoughness});
  if (options_.fence_post_spacing == 0.0) return;

  Random random(options_.seed, kLayout);
  const auto add_posts = [&](const Eigen::Vector2d& begin, const Eigen::Vector2d& end) {
    const int gaps = std::max(1, static_cast<int>(std::round((end - begin).norm() / options_.fence_post_spacing)));
    for (int i = 0; i < gaps; ++i) {
      const double dx = random.Uniform(-0.1, 0.1);
      const double dy = random.Uniform(-0.1, 0.1);
      const Eigen::Vector2d place = begin + (end - begin) * (static_cast<double>(i) / gaps);
      world_.discs.push_back({place + Eigen::Vector2d(dx, dy), kPostRadius});
    }
  };
  add_posts({low.x(), high.y()}, low);
  add_posts(low, {high.x(), low.y()});
  add_posts({high.x(), low.y()}, high);
}

SE2 PlanarOrchard::TruePose(size_t index) const {
  Random random(options_.seed, kPoses + index);
  const double along = options_.step_jitter * random.Gaussian();
  const double across = options_.sway * random.Gaussian();
  const double turn = options_.heading_jitter * random.Gaussian();
  const double distance = step_ * static_cast<double>(index) + along;
  // A whole number of waves, none at the start: the path stays closed.
  const double wave_number = 2.0 * kPi * std::max(1.0, std::round(path_.Length() / kWanderWavelength)) / path_.Length();
  const double wander = options_.wander * std::sin(wave_number * distance);
  const double wander_heading = std::atan(options_.wander * wave_number * std::cos(wave_number * distance));
  return path_.At(distance) * SE2(0.0, wander + across, wander_heading + turn);
}

Tilt PlanarOrchard::TiltOf(size_t index) const {
  Random random(options_.seed, kTilts + index);
  if (!(random.Uniform() < options_.spoilt_scans)) return {};
  const double angle = random.Uniform(kMinSpoiltTilt, kMaxSpoiltTilt);
  return {angle, random.Uniform(-kPi, kPi)};
}

LaserScan PlanarOrchard::Scan(size_t index) const {
  Random random(options_.seed, kBeams + index);
  return lidar_.Measure(world_, TruePose(index), Stamp(index), TiltOf(index), &random);
}

Trajectory PlanarOrchard::GroundTruth() const {
  Trajectory trajectory;
  trajectory.reserve(num_scans_);
  for (size_t i = 0; i < num_scans_; ++i) trajectory.push_back({Stamp(i), TruePose(i)});
  return trajectory;
}

}  // namespace arborslam
