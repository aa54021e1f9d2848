#include "core/simulation/uneven_ground.h"

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
constexpr double kWaveSampling = 2.0;       // [m], where their height is looked up.
constexpr int kNodesPerPatch = 5;           // Grass grows in patches of about this size.
constexpr double kClumpFactor = 2.5;        // Height of a clump over that of the usual grass.
constexpr double kNudge = 1e-9;             // [m], over the border of a cell.
constexpr double kFloorMargin = 0.01;       // [m], below the lowest ground.
constexpr int kPeakReaches[] = {32, 8, 2};  // [nodes], the distances over which a beam may skip.

// The streams of the seed.
enum Stream : uint64_t { kWaves = 100, kBumps = 101, kGrass = 102 };

// The least x > 0 with a x^2 + b x + c = 0, where c > 0; infinite if there is none.
double FirstRoot(double a, double b, double c) {
  const double discriminant = b * b - 4.0 * a * c;
  if (discriminant < 0.0) return kInfinity;
  // As 2 c / (-b +- root): without cancellation for the root that is asked for, and right for a = 0. That root is the
  // one with the + sign: for a < 0 the only positive one, for a > 0 the smaller.
  const double denominator = -b + std::sqrt(discriminant);
  return denominator > 0.0 ? 2.0 * c / denominator : kInfinity;
}

}  // namespace

std::string UnevenGroundOptions::Validate() const {
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

UnevenGround::UnevenGround(const UnevenGroundOptions& options, uint64_t seed, const Eigen::Vector2d& low,
                           const Eigen::Vector2d& high)
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
  highest_ = -kInfinity;
  lowest_ = kInfinity;
  for (int j = 0; j < height_; ++j) {
    for (int i = 0; i < width_; ++i) {
      const double bump = options.bumps * std::clamp(bump_random.Gaussian(), -2.0, 2.0);
      ground_.push_back(static_cast<float>(Waves(low + kNodeSpacing * Eigen::Vector2d(i, j)) + bump));
      highest_ = std::max<double>(highest_, ground_.back());
      lowest_ = std::min<double>(lowest_, ground_.back());
    }
  }
  for (size_t i = 0; i < peaks_.size(); ++i) peaks_[i] = Peaks(ground_, width_, height_, kPeakReaches[i]);

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

UnevenGround::Peaks::Peaks(const std::vector<float>& nodes, int width, int height, int reach_in)
    : reach(reach_in), across((width - 1) / reach_in + 1) {
  const int up = (height - 1) / reach + 1;
  heights.assign(static_cast<size_t>(across) * static_cast<size_t>(up), -std::numeric_limits<float>::infinity());
  // A square's peak counts for its neighbours too: from anywhere in a square, `reach` leads no farther.
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const float node = nodes[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
      // A node also bounds the cells before it.
      for (int y = std::max(0, (j - 1) / reach - 1); y <= std::min(up - 1, j / reach + 1); ++y) {
        for (int x = std::max(0, (i - 1) / reach - 1); x <= std::min(across - 1, i / reach + 1); ++x) {
          float& peak = heights[static_cast<size_t>(y) * static_cast<size_t>(across) + static_cast<size_t>(x)];
          peak = std::max(peak, node);
        }
      }
    }
  }
}

double UnevenGround::Waves(const Eigen::Vector2d& position) const {
  double height = offset_;
  for (const Wave& wave : waves_) height += wave.amplitude * std::sin(wave.wave_number.dot(position) + wave.phase);
  return height;
}

Eigen::Vector2d UnevenGround::SmoothGradient(const Eigen::Vector2d& position) const {
  Eigen::Vector2d gradient = slope_;
  for (const Wave& wave : waves_) {
    gradient += wave.amplitude * std::cos(wave.wave_number.dot(position) + wave.phase) * wave.wave_number;
  }
  return gradient;
}

double UnevenGround::Sample(const Eigen::Vector2d& position, const std::vector<float>& nodes) const {
  const double x = std::clamp((position.x() - low_.x()) / kNodeSpacing, 0.0, width_ - 1.001);
  const double y = std::clamp((position.y() - low_.y()) / kNodeSpacing, 0.0, height_ - 1.001);
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const double u = x - i;
  const double v = y - j;
  const float* const node = &nodes[static_cast<size_t>(j) * static_cast<size_t>(width_) + static_cast<size_t>(i)];
  return (1.0 - v) * ((1.0 - u) * node[0] + u * node[1]) + v * ((1.0 - u) * node[width_] + u * node[width_ + 1]);
}

double UnevenGround::RangeToFloor(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  const double climb = direction.z() - slope_.dot(direction.head<2>());
  const double level = origin.z() - slope_.dot(origin.head<2>());
  return climb < 0.0 ? std::max(0.0, (level - lowest_ + kFloorMargin) / -climb) : kInfinity;
}

double UnevenGround::Descend(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double begin,
                             double max_range, double offset) const {
  const Eigen::Vector2d start = (origin.head<2>() - low_) / kNodeSpacing;
  const Eigen::Vector2d step = direction.head<2>() / kNodeSpacing;
  // Over the slope, which is a plane.
  const double level = origin.z() - slope_.dot(origin.head<2>()) - offset;
  const double climb = direction.z() - slope_.dot(direction.head<2>());
  const double pace = std::max(step.norm(), 1e-9);  // [nodes/m].
  for (double range = begin; range <= max_range;) {
    const Eigen::Vector2d place = start + range * step;
    if (!(place.x() >= 0.0 && place.x() < width_ - 1 && place.y() >= 0.0 && place.y() < height_ - 1)) return kInfinity;
    const double height = level + climb * range;
    if (climb >= 0.0 && height > highest_) return kInfinity;
    const int i = static_cast<int>(place.x());
    const int j = static_cast<int>(place.y());
    // Over low ground far and wide the beam goes on at once.
    bool is_clear = false;
    for (const Peaks& peaks : peaks_) {
      const double stride = peaks.reach / pace;
      const double lowest_on_the_way = height + std::min(0.0, climb * stride);
      if (lowest_on_the_way <= peaks.At(i, j)) continue;
      range += stride;
      is_clear = true;
      break;
    }
    if (is_clear) continue;
    // Within the cell the ground is a + b u + c v + e u v, and the gap to the beam a quadratic.
    const float* const node = &ground_[static_cast<size_t>(j) * static_cast<size_t>(width_) + static_cast<size_t>(i)];
    const double u = place.x() - i;
    const double v = place.y() - j;
    const double slope_u = node[1] - node[0];
    const double slope_v = node[width_] - node[0];
    const double twist = static_cast<double>(node[width_ + 1]) - node[width_] - slope_u;
    const double gap = height - (node[0] + slope_u * u + slope_v * v + twist * u * v);
    if (gap <= 0.0) return range;
    const double exit_u = step.x() > 0.0 ? (1.0 - u) / step.x() : (step.x() < 0.0 ? -u / step.x() : kInfinity);
    const double exit_v = step.y() > 0.0 ? (1.0 - v) / step.y() : (step.y() < 0.0 ? -v / step.y() : kInfinity);
    const double exit = std::min({exit_u, exit_v, max_range - range + kNudge});
    const double rate = climb - (slope_u * step.x() + slope_v * step.y() + twist * (u * step.y() + v * step.x()));
    const double hit = FirstRoot(-twist * step.x() * step.y(), rate, gap);
    if (hit <= exit) return range + hit <= max_range ? range + hit : kInfinity;
    range += exit + kNudge;
  }
  return kInfinity;
}

double UnevenGround::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double max_range,
                          Random* random) const {
  const double entry = Descend(origin, direction, 0.0, max_range, max_grass_);
  if (max_grass_ == 0.0 || entry == kInfinity) return entry;
  const double soil = Descend(origin, direction, entry, max_range, 0.0);
  // Draws as if grass stood everywhere as high as the highest, and passes over what was drawn outside (Woodcock 1965).
  for (double range = entry;;) {
    range += random->Exponential() / grass_density_;
    if (range >= std::min(soil, max_range)) return soil;
    const Eigen::Vector3d point = origin + range * direction;
    const double above = point.z() - Height(point.head<2>());
    if (above < GrassHeight(point.head<2>())) return range;
    // Out of the grass the beam goes on to where it comes back.
    if (above > max_grass_) range = std::max(range, Descend(origin, direction, range, max_range, max_grass_));
  }
}

}  // namespace arborslam
