#include "core/simulation/terrain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/config/validation.h"
#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNodeSpacing = 0.25;  // [m].
constexpr int kNumWaves = 6;
constexpr double kWaveSampling = 2.0;   // [m], where their height is looked up.
constexpr int kNodesPerPatch = 5;       // Grass grows in patches of about this size.
constexpr double kClumpFactor = 2.5;    // Height of a clump over that of the usual grass.
constexpr double kShortestStep = 0.02;  // [m] of a beam over the ground, growing with the range.
constexpr double kStepGrowth = 0.002;

// The streams of the seed.
enum Stream : uint64_t { kWaves = 100, kBumps = 101, kGrass = 102 };

}  // namespace

std::string TerrainOptions::Validate() const {
  if (!(undulation >= 0.0 && undulation <= 10.0)) return Violation("undulation", undulation, "lie in [0, 10]");
  if (!(wavelength >= 1.0 && wavelength <= 1000.0)) return Violation("wavelength", wavelength, "lie in [1, 1000]");
  if (!(slope >= 0.0 && slope <= 30.0)) return Violation("slope", slope, "lie in [0, 30]");
  if (!(std::abs(slope_direction) <= 360.0)) {
    return Violation("slope_direction", slope_direction, "lie in [-360, 360]");
  }
  if (!(bumps >= 0.0 && bumps <= 0.2)) return Violation("bumps", bumps, "lie in [0, 0.2]");
  if (!(grass_height >= 0.0 && grass_height <= 2.0)) return Violation("grass_height", grass_height, "lie in [0, 2]");
  const std::pair<const char*, double> shares[] = {{"grass_cover", grass_cover}, {"grass_clumps", grass_clumps}};
  for (const auto& [key, value] : shares) {
    if (!(value >= 0.0 && value <= 1.0)) return Violation(key, value, "lie in [0, 1]");
  }
  if (!(grass_density > 0.0 && grass_density <= 1000.0)) {
    return Violation("grass_density", grass_density, "lie in (0, 1000]");
  }
  return "";
}

Terrain::Terrain(const TerrainOptions& options, uint64_t seed, const Eigen::Vector2d& low, const Eigen::Vector2d& high)
    : grass_density_(options.grass_density), low_(low) {
  const double direction = DegToRad(options.slope_direction);
  slope_ = std::tan(DegToRad(options.slope)) * Eigen::Vector2d(std::cos(direction), std::sin(direction));

  Random wave_random(seed, kWaves);
  for (int i = 0; i < kNumWaves && options.undulation > 0.0; ++i) {
    const double wave_number = 2.0 * kPi / (options.wavelength * wave_random.Uniform(0.6, 1.4));
    const double bearing = wave_random.Uniform(-kPi, kPi);
    const Eigen::Vector2d vector = wave_number * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    waves_.push_back({vector, wave_random.Uniform(-kPi, kPi), wave_random.Uniform(0.5, 1.0)});
  }
  offset_ = -Waves(Eigen::Vector2d::Zero());
  double highest = 1e-6;
  for (double x = low.x(); x <= high.x(); x += kWaveSampling) {
    for (double y = low.y(); y <= high.y(); y += kWaveSampling) {
      highest = std::max(highest, std::abs(Waves({x, y})));
    }
  }
  for (Wave& wave : waves_) wave.amplitude *= options.undulation / highest;
  offset_ = -(Waves(Eigen::Vector2d::Zero()) - offset_);

  width_ = 2 + static_cast<int>(std::ceil((high.x() - low.x()) / kNodeSpacing));
  height_ = 2 + static_cast<int>(std::ceil((high.y() - low.y()) / kNodeSpacing));
  const size_t num_nodes = static_cast<size_t>(width_) * static_cast<size_t>(height_);
  ground_.reserve(num_nodes);
  Random bump_random(seed, kBumps);
  max_ground_ = -kInfinity;
  for (int j = 0; j < height_; ++j) {
    for (int i = 0; i < width_; ++i) {
      const double bump = options.bumps * std::clamp(bump_random.Gaussian(), -2.0, 2.0);
      ground_.push_back(static_cast<float>(Waves(low + kNodeSpacing * Eigen::Vector2d(i, j)) + bump));
      max_ground_ = std::max<double>(max_ground_, ground_.back());
    }
  }
  double steepest_x = 0.0;
  double steepest_y = 0.0;
  for (size_t node = 0; node < num_nodes; ++node) {
    if ((node + 1) % width_ != 0) {
      steepest_x = std::max<double>(steepest_x, std::abs(ground_[node + 1] - ground_[node]));
    }
    if (node + width_ < num_nodes) {
      steepest_y = std::max<double>(steepest_y, std::abs(ground_[node + width_] - ground_[node]));
    }
  }
  steepness_ = std::hypot(steepest_x, steepest_y) / kNodeSpacing;

  if (options.grass_height <= 0.0 || options.grass_cover <= 0.0) return;
  Random grass_random(seed, kGrass);
  const int patches_across = width_ / kNodesPerPatch + 2;
  const int patches_up = height_ / kNodesPerPatch + 2;
  std::vector<double> patches(static_cast<size_t>(patches_across) * static_cast<size_t>(patches_up));
  for (double& patch : patches) patch = grass_random.Uniform();
  grass_.reserve(num_nodes);
  for (int j = 0; j < height_; ++j) {
    for (int i = 0; i < width_; ++i) {
      const bool is_grown = patches[(j / kNodesPerPatch) * patches_across + i / kNodesPerPatch] < options.grass_cover;
      const bool is_clump = grass_random.Uniform() < options.grass_clumps;
      const double height = (is_clump ? kClumpFactor : 1.0) * options.grass_height * grass_random.Uniform(0.3, 1.0);
      grass_.push_back(is_grown ? static_cast<float>(height) : 0.0f);
      max_grass_ = std::max<double>(max_grass_, grass_.back());
    }
  }
}

double Terrain::Waves(const Eigen::Vector2d& position) const {
  double height = offset_;
  for (const Wave& wave : waves_) height += wave.amplitude * std::sin(wave.wave_number.dot(position) + wave.phase);
  return height;
}

Eigen::Vector2d Terrain::SmoothGradient(const Eigen::Vector2d& position) const {
  Eigen::Vector2d gradient = slope_;
  for (const Wave& wave : waves_) {
    gradient += wave.amplitude * std::cos(wave.wave_number.dot(position) + wave.phase) * wave.wave_number;
  }
  return gradient;
}

double Terrain::Sample(const Eigen::Vector2d& position, const std::vector<float>& nodes) const {
  const double x = std::clamp((position.x() - low_.x()) / kNodeSpacing, 0.0, width_ - 1.001);
  const double y = std::clamp((position.y() - low_.y()) / kNodeSpacing, 0.0, height_ - 1.001);
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const double u = x - i;
  const double v = y - j;
  const float* const node = &nodes[static_cast<size_t>(j) * static_cast<size_t>(width_) + static_cast<size_t>(i)];
  return (1.0 - v) * ((1.0 - u) * node[0] + u * node[1]) + v * ((1.0 - u) * node[width_] + u * node[width_ + 1]);
}

double Terrain::Descend(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double begin, double max_range,
                        double offset) const {
  const Eigen::Vector2d start = origin.head<2>();
  const Eigen::Vector2d heading = direction.head<2>();
  // Over the slope, which is a plane.
  const double level = origin.z() - slope_.dot(start) - offset;
  const double climb = direction.z() - slope_.dot(heading);
  const double fastest_approach = steepness_ * heading.norm() - climb;
  if (fastest_approach <= 0.0) return kInfinity;
  double range = begin;
  double gap = level + climb * range - Sample(start + range * heading, ground_);
  while (gap > 0.0) {
    if (climb >= 0.0 && level + climb * range > max_ground_) return kInfinity;
    const double step = std::max(gap / fastest_approach, kShortestStep + kStepGrowth * range);
    const double next = range + step;
    if (range >= max_range) return kInfinity;
    const double next_gap = level + climb * next - Sample(start + next * heading, ground_);
    if (next_gap > 0.0) {
      range = next;
      gap = next_gap;
      continue;
    }
    // Between `range` and `next`.
    double high = next;
    double high_gap = next_gap;
    for (int i = 0; i < 4 && high - range > 1e-5; ++i) {
      const double middle = range + (high - range) * gap / (gap - high_gap);
      const double middle_gap = level + climb * middle - Sample(start + middle * heading, ground_);
      if (middle_gap > 0.0) {
        range = middle;
        gap = middle_gap;
      } else {
        high = middle;
        high_gap = middle_gap;
      }
    }
    range += (high - range) * gap / (gap - high_gap);
    break;
  }
  return range <= max_range ? range : kInfinity;
}

Terrain::Hit Terrain::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double max_range,
                           Random* random) const {
  const double entry = Descend(origin, direction, 0.0, max_range, max_grass_);
  if (max_grass_ == 0.0 || entry == kInfinity) return {entry, false};
  const double soil = Descend(origin, direction, entry, max_range, 0.0);
  // Draws as if grass stood everywhere as high as the highest, and passes over what was drawn outside (Woodcock 1965).
  for (double range = entry;;) {
    range += random->Exponential() / grass_density_;
    if (range >= std::min(soil, max_range)) return {soil, false};
    const Eigen::Vector3d point = origin + range * direction;
    const double above = point.z() - Height(point.head<2>());
    if (above > max_grass_ && direction.z() - slope_.dot(direction.head<2>()) > steepness_) return {soil, false};
    if (above < GrassHeight(point.head<2>())) return {range, true};
  }
}

}  // namespace arborslam
