#include "frontend/matching/match_target.h"

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

// [m], edge of the patches by which surfaces are looked at: three by three of them, half a metre, hold a trunk's
// visible side or a stretch of a hedge.
constexpr float kPatchSize = 0.16f;
// [m], spread that range noise and cell size alone give a surface across itself.
constexpr float kSurfaceNoise = 0.025f;

// Weighted sums over the landmarks of a patch, relative to its corner.
struct Moments {
  float weight = 0.0f;
  Eigen::Vector2f first = Eigen::Vector2f::Zero();
  Eigen::Vector3f second = Eigen::Vector3f::Zero();  // xx, xy, yy

  // Adds `other`, whose corner lies `shift` [m] from this one's.
  void Add(const Moments& other, const Eigen::Vector2f& shift) {
    weight += other.weight;
    first += other.first + other.weight * shift;
    second.x() += other.second.x() + 2.0f * shift.x() * other.first.x() + other.weight * shift.x() * shift.x();
    second.y() += other.second.y() + shift.x() * other.first.y() + shift.y() * other.first.x() +
                  other.weight * shift.x() * shift.y();
    second.z() += other.second.z() + 2.0f * shift.y() * other.first.y() + other.weight * shift.y() * shift.y();
  }
};

// What a surface with these moments tells of a point on it: I - (1 - ratio) along along^T, where `along` is the
// direction of the greatest spread and `ratio` the least variance over the greatest.
Eigen::Vector3f SurfaceInformation(const Moments& moments) {
  const Eigen::Vector2f mean = moments.first / moments.weight;
  const float noise = kSurfaceNoise * kSurfaceNoise;
  const float xx = moments.second.x() / moments.weight - mean.x() * mean.x() + noise;
  const float xy = moments.second.y() / moments.weight - mean.x() * mean.y();
  const float yy = moments.second.z() / moments.weight - mean.y() * mean.y() + noise;
  const float half_sum = 0.5f * (xx + yy);
  const float half_difference = 0.5f * (xx - yy);
  const float radius = std::sqrt(half_difference * half_difference + xy * xy);
  if (radius <= 0.0f) return {1.0f, 0.0f, 1.0f};
  const float ratio = std::max(0.0f, half_sum - radius) / (half_sum + radius);
  const float half_loss = 0.5f * (1.0f - ratio);
  const float c = half_difference / radius;
  const float s = xy / radius;
  return {1.0f - half_loss * (1.0f + c), -half_loss * s, 1.0f - half_loss * (1.0f - c)};
}

}  // namespace

MatchTarget::MatchTarget(const std::vector<OccupiedCell>& cells, double cell_size, double max_distance) {
  std::vector<Eigen::Vector2f> points;
  points.reserve(cells.size());
  landmarks_.reserve(cells.size());
  float most = 0.0f;
  for (const OccupiedCell& cell : cells) most = std::max(most, cell.log_odds);
  for (const OccupiedCell& cell : cells) {
    points.push_back(cell.centroid);
    landmarks_.push_back({cell.centroid, most > 0.0f ? cell.log_odds / most : 1.0f, {1.0f, 0.0f, 1.0f}});
  }
  field_ = DistanceField(points, cell_size, max_distance, DistanceMetric::kL2);
  FitShapes();
}

void MatchTarget::FitShapes() {
  if (landmarks_.empty()) return;
  Eigen::Vector2f low = landmarks_.front().centroid;
  Eigen::Vector2f high = low;
  for (const Landmark& landmark : landmarks_) {
    low = low.cwiseMin(landmark.centroid);
    high = high.cwiseMax(landmark.centroid);
  }
  // At least one empty patch all around, so that every patch has eight neighbours.
  low.array() -= 1.5f * kPatchSize;
  const int width = static_cast<int>((high.x() - low.x()) / kPatchSize) + 3;
  const int height = static_cast<int>((high.y() - low.y()) / kPatchSize) + 3;
  std::vector<int32_t> patch_at(static_cast<size_t>(width) * static_cast<size_t>(height), -1);
  std::vector<Moments> patches;
  std::vector<size_t> places;                       // Of the patches, in patch_at.
  std::vector<size_t> patch_of(landmarks_.size());  // Of the landmarks, in patches.
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const Eigen::Vector2f position = (landmarks_[i].centroid - low) / kPatchSize;
    const int x = static_cast<int>(position.x());
    const int y = static_cast<int>(position.y());
    const size_t place = static_cast<size_t>(x) * static_cast<size_t>(height) + static_cast<size_t>(y);
    if (patch_at[place] < 0) {
      patch_at[place] = static_cast<int32_t>(patches.size());
      patches.emplace_back();
      places.push_back(place);
    }
    patch_of[i] = static_cast<size_t>(patch_at[place]);
    const float dx = (position.x() - static_cast<float>(x)) * kPatchSize;
    const float dy = (position.y() - static_cast<float>(y)) * kPatchSize;
    const float weight = landmarks_[i].weight;
    Moments& moments = patches[patch_of[i]];
    moments.weight += weight;
    moments.first += weight * Eigen::Vector2f(dx, dy);
    moments.second += weight * Eigen::Vector3f(dx * dx, dx * dy, dy * dy);
  }
  std::vector<Eigen::Vector3f> information(patches.size());
  for (size_t i = 0; i < patches.size(); ++i) {
    Moments around;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const int32_t neighbour = patch_at[places[i] + static_cast<size_t>(x * height + y)];
        if (neighbour < 0) continue;
        around.Add(patches[static_cast<size_t>(neighbour)], kPatchSize * Eigen::Vector2f(x, y));
      }
    }
    information[i] = SurfaceInformation(around);
  }
  for (size_t i = 0; i < landmarks_.size(); ++i) landmarks_[i].information = information[patch_of[i]];
}

const MinPyramid& MatchTarget::Pyramid(int num_levels) const {
  if (pyramid_.empty()) pyramid_.emplace_back(field_, num_levels);
  pyramid_.front().Extend(num_levels);
  return pyramid_.front();
}

}  // namespace arborslam
