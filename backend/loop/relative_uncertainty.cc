#include "backend/loop/relative_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace arborslam {
namespace {

// [1/m^2, 1/rad^2], what is known of a direction that a measurement leaves open: it is in the search's window.
constexpr double kLeastInformation = 1.0;
// [m], by this lever arm a heading's variance is weighed against a position's.
constexpr double kLeverArm = 10.0;
// So many standard deviations around a prediction are searched.
constexpr double kSearchedSigmas = 3.0;

double SizeOf(const Eigen::Matrix3d& covariance) {
  return covariance(0, 0) + covariance(1, 1) + kLeverArm * kLeverArm * covariance(2, 2);
}

// The covariance of a rigid thing about a point that lies `shift` [m] from the one that `covariance` is about.
Eigen::Matrix3d Shifted(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& shift) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(0, 2) = -shift.y();
  jacobian(1, 2) = shift.x();
  return jacobian * covariance * jacobian.transpose();
}

Eigen::Matrix3d CovarianceInMap(const Constraint& constraint, const SE2& T_map_to) {
  const Eigen::Matrix3d information = constraint.information + kLeastInformation * Eigen::Matrix3d::Identity();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() = T_map_to.rotation();
  return axes * information.inverse() * axes.transpose();
}

}  // namespace

RelativeUncertainty::RelativeUncertainty(const PoseGraph& graph) : graph_(graph) {
  for (const Constraint& constraint : graph.constraints()) {
    if (constraint.from.kind != NodeId::Kind::kSubmap || constraint.to.kind != NodeId::Kind::kKeyframe) continue;
    sightings_[constraint.to.value].push_back(
        {constraint.from.value, CovarianceInMap(constraint, graph.Pose(constraint.to))});
  }
  for (const auto& [keyframe, sightings] : sightings_) {
    for (const Sighting& a : sightings) {
      for (const Sighting& b : sightings) {
        if (a.submap == b.submap) continue;
        const Link link{keyframe, a.covariance, b.covariance};
        const auto [found, is_new] = links_[a.submap].emplace(b.submap, link);
        const Link& known = found->second;
        if (!is_new && SizeOf(a.covariance + b.covariance) < SizeOf(known.to_keyframe + known.from_keyframe)) {
          found->second = link;
        }
      }
    }
  }
}

RelativeUncertainty::View RelativeUncertainty::From(SubmapId submap) const {
  // Dijkstra (1959) by the size of the covariance.
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
  std::map<int, Eigen::Matrix3d> reached{{submap.value, Eigen::Matrix3d::Zero()}};
  std::map<int, Eigen::Matrix3d> settled;
  open.emplace(0.0, submap.value);
  while (!open.empty()) {
    const int from = open.top().second;
    open.pop();
    const Eigen::Matrix3d covariance = reached.at(from);
    if (!settled.emplace(from, covariance).second) continue;
    const auto links = links_.find(from);
    if (links == links_.end()) continue;
    const Eigen::Vector2d& position = graph_.Pose(SubmapId{from}).translation();
    for (const auto& [to, link] : links->second) {
      if (settled.count(to) > 0) continue;
      const Eigen::Vector2d& between = graph_.Pose(KeyframeId{link.keyframe}).translation();
      const Eigen::Vector2d& end = graph_.Pose(SubmapId{to}).translation();
      const Eigen::Matrix3d candidate =
          Shifted(Shifted(covariance, between - position) + link.to_keyframe + link.from_keyframe, end - between);
      const auto [found, is_new] = reached.emplace(to, candidate);
      if (!is_new && SizeOf(found->second) <= SizeOf(candidate)) continue;
      found->second = candidate;
      open.emplace(SizeOf(candidate), to);
    }
  }
  return View(*this, std::move(settled));
}

std::optional<Eigen::Matrix3d> RelativeUncertainty::View::Of(KeyframeId keyframe) const {
  std::optional<Eigen::Matrix3d> best;
  const auto found = parent_.sightings_.find(keyframe.value);
  if (found == parent_.sightings_.end()) return best;
  const Eigen::Vector2d& position = parent_.graph_.Pose(keyframe).translation();
  for (const Sighting& sighting : found->second) {
    const auto known = covariances_.find(sighting.submap);
    if (known == covariances_.end()) continue;
    const Eigen::Vector2d& origin = parent_.graph_.Pose(SubmapId{sighting.submap}).translation();
    const Eigen::Matrix3d covariance = Shifted(known->second, position - origin) + sighting.covariance;
    if (!best || SizeOf(covariance) < SizeOf(*best)) best = covariance;
  }
  return best;
}

SearchedWindow WindowOf(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>(), Eigen::EigenvaluesOnly);
  return {kSearchedSigmas * std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff())),
          kSearchedSigmas * std::sqrt(std::max(0.0, covariance(2, 2)))};
}

}  // namespace arborslam
