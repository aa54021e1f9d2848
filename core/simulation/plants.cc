#include "core/simulation/plants.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kRootDepth = 0.3;  // [m], how deep trunks and posts stand in the ground.

// The direction of an axis that leans by about `lean` [deg].
Eigen::Vector3d LeaningAxis(double lean, Random* random) {
  const double x = std::tan(DegToRad(lean)) * random->Gaussian();
  const double y = std::tan(DegToRad(lean)) * random->Gaussian();
  return Eigen::Vector3d(x, y, 1.0).normalized();
}

// An upright frustum that stands in the ground at `place` and has `radius` there.
Frustum Standing(const Eigen::Vector2d& place, const UnevenGround& terrain, const Eigen::Vector3d& axis, double length,
                 double radius, double top_radius) {
  const Eigen::Vector3d foot(place.x(), place.y(), terrain.Height(place));
  const double depth_radius = radius + (radius - top_radius) * kRootDepth / length;
  return {foot - kRootDepth * axis, axis, length + kRootDepth, depth_radius, top_radius};
}

}  // namespace

void PlantTree(const Eigen::Vector2d& place, const TreeShape& shape, Random* random, World3* world) {
  const double ground = world->terrain.Height(place);
  const double size = random->Uniform(0.85, 1.15);
  const double radius = shape.trunk_radius * random->Uniform(0.75, 1.25);
  const Eigen::Vector3d axis = LeaningAxis(shape.lean, random);
  const double height = shape.trunk_height * random->Uniform(0.9, 1.1);
  world->solids.push_back(Standing(place, world->terrain, axis, height, radius, radius * shape.top_share));
  const Eigen::Vector3d foot(place.x(), place.y(), ground);

  const double crown_middle = 0.5 * (shape.crown_base + shape.crown_top) * size;
  const double half_height = 0.5 * (shape.crown_top - shape.crown_base) * size;
  for (int i = 0; i < shape.limbs; ++i) {
    // From the trunk at the crown's base or its upper end outwards, never below a metre.
    const double along = std::max(1.0, std::min(height, shape.crown_base * size + 0.2));
    const double bearing = 2.0 * kPi * (i + random->Uniform(-0.3, 0.3)) / shape.limbs;
    const double reach = shape.crown_radius * size * random->Uniform(0.4, 0.8);
    const Eigen::Vector3d begin = foot + along * axis;
    const Eigen::Vector3d end =
        begin + Eigen::Vector3d(reach * std::cos(bearing), reach * std::sin(bearing), half_height * 0.9);
    world->solids.push_back(Frustum::Between(begin, end, 0.45 * radius, 0.15 * radius));
  }
  for (int i = 0; i < shape.crown_parts; ++i) {
    Leaves leaves;
    const bool is_middle = i == 0;
    const double bearing = random->Uniform(-kPi, kPi);
    const double reach = is_middle ? 0.0 : 0.5 * shape.crown_radius * size;
    const double share = is_middle ? 1.0 : random->Uniform(0.5, 0.7);
    const double rise = is_middle ? 0.0 : half_height * random->Uniform(-0.4, 0.4);
    leaves.center =
        foot + crown_middle * axis + Eigen::Vector3d(reach * std::cos(bearing), reach * std::sin(bearing), rise);
    const double wide = share * shape.crown_radius * size * (is_middle && shape.crown_parts > 1 ? 0.8 : 1.0);
    leaves.extent = {wide * random->Uniform(0.9, 1.1), wide * random->Uniform(0.9, 1.1),
                     std::min(half_height, share * half_height * 1.1)};
    leaves.yaw = random->Uniform(-kPi, kPi);
    leaves.density = shape.leaf_density * random->Uniform(0.7, 1.3);
    world->leaves.push_back(leaves);
  }
}

void SetPost(const Eigen::Vector2d& place, double radius, double height, double lean, Random* random, World3* world) {
  world->solids.push_back(Standing(place, world->terrain, LeaningAxis(lean, random), height, radius, radius));
}

void SetFence(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double spacing, Random* random, World3* world) {
  constexpr double kRadius = 0.05;
  constexpr double kHeight = 1.5;
  const int gaps = std::max(1, static_cast<int>(std::round((end - begin).norm() / spacing)));
  for (int i = 0; i < gaps; ++i) {
    const double dx = random->Uniform(-0.1, 0.1);
    const double dy = random->Uniform(-0.1, 0.1);
    const Eigen::Vector2d place = begin + (end - begin) * (static_cast<double>(i) / gaps) + Eigen::Vector2d(dx, dy);
    SetPost(place, kRadius, kHeight, 1.5, random, world);
  }
}

void PlantBush(const Eigen::Vector2d& place, double radius, double height, double leaf_density, World3* world) {
  Leaves leaves;
  leaves.center = {place.x(), place.y(), world->terrain.Height(place) + 0.4 * height};
  leaves.extent = {radius, radius, 0.6 * height};
  leaves.density = leaf_density;
  world->leaves.push_back(leaves);
}

void PlantLeafWall(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, const LeafWallShape& shape, Random* random,
                   World3* world) {
  const Eigen::Vector2d extent = end - begin;
  const int pieces = std::max(1, static_cast<int>(std::round(extent.norm())));
  for (int i = 0; i < pieces; ++i) {
    const bool missing = random->Uniform() < shape.gaps;
    const double bottom = shape.bottom * random->Uniform(0.85, 1.15);
    const double top = shape.top * random->Uniform(0.9, 1.1);
    const double thickness = shape.thickness * random->Uniform(0.7, 1.3);
    const double aside = 0.15 * shape.thickness * random->Gaussian();
    const double density = shape.leaf_density * random->Uniform(0.6, 1.4);
    if (missing) continue;
    const Eigen::Vector2d place = begin + extent * ((i + 0.5) / pieces);
    Leaves leaves;
    leaves.shape = Leaves::Shape::kBox;
    leaves.yaw = std::atan2(extent.y(), extent.x()) + 0.05 * random->Gaussian();
    const Eigen::Vector2d across(-std::sin(leaves.yaw), std::cos(leaves.yaw));
    const double ground = world->terrain.SmoothHeight(place);
    leaves.center << place + aside * across, ground + 0.5 * (bottom + top);
    leaves.extent = {0.55 * extent.norm() / pieces, 0.5 * thickness, 0.5 * (top - bottom)};
    leaves.density = density;
    world->leaves.push_back(leaves);
  }
}

}  // namespace arborslam
