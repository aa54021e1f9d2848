#include "core/evaluation/relations.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr double kMaxCoordinate = 1e9;  // [m]
constexpr char kLayout[] = "t1 t2 x y z roll pitch yaw";

// Mean and standard deviation of `values`, of which there is at least one, and the greatest.
struct Spread {
  double mean = 0.0;
  double sd = 0.0;
  double max = 0.0;
};

Spread SpreadOf(const std::vector<double>& values) {
  Spread spread;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) {
    spread.mean += value / count;
    spread.max = std::max(spread.max, value);
  }
  double variance = 0.0;
  for (const double value : values) variance += (value - spread.mean) * (value - spread.mean) / count;
  spread.sd = std::sqrt(variance);
  return spread;
}

Eigen::Isometry3d PoseOf(const StampedPose3& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(pose.position);
  T.rotate(pose.orientation.normalized());
  return T;
}

// The pose of `sorted` that is nearest in time, if that is near enough.
std::optional<Eigen::Isometry3d> PoseAt(const std::vector<StampedPose3>& sorted, double stamp, double max_difference) {
  auto nearest = std::lower_bound(sorted.begin(), sorted.end(), stamp,
                                  [](const StampedPose3& pose, double value) { return pose.stamp < value; });
  if (nearest == sorted.end() ||
      (nearest != sorted.begin() && stamp - (nearest - 1)->stamp <= nearest->stamp - stamp)) {
    if (nearest == sorted.begin()) return std::nullopt;
    --nearest;
  }
  if (std::abs(nearest->stamp - stamp) > max_difference) return std::nullopt;
  return PoseOf(*nearest);
}

}  // namespace

std::vector<Relation> ReadRelations(const std::string& path) {
  TextReader reader(path);
  std::vector<Relation> relations;
  while (reader.Next()) {
    reader.ExpectFields(8, kLayout);
    const auto coordinate = [&reader](size_t index, const char* name) {
      const double value = reader.Number(index, name);
      if (std::abs(value) > kMaxCoordinate) {
        throw UserError(reader.Place(), std::string(name) + " is beyond 1e9", "correct or remove the line");
      }
      return value;
    };
    Relation relation;
    relation.from_stamp = reader.Number(0, "t1");
    relation.to_stamp = reader.Number(1, "t2");
    const Eigen::Vector3d position(coordinate(2, "x"), coordinate(3, "y"), coordinate(4, "z"));
    relation.T_from_to = Eigen::Translation3d(position) *
                         Eigen::AngleAxisd(coordinate(7, "yaw"), Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(coordinate(6, "pitch"), Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(coordinate(5, "roll"), Eigen::Vector3d::UnitX());
    relations.push_back(relation);
  }
  if (relations.empty()) {
    throw UserError(path, "holds no relations", std::string("write one a line, '") + kLayout + "'");
  }
  return relations;
}

RelationMetrics EvaluateRelations(const Trajectory3& estimate, const std::vector<Relation>& relations,
                                  double max_time_difference, const std::string& place) {
  std::vector<StampedPose3> sorted = estimate.poses;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const StampedPose3& a, const StampedPose3& b) { return a.stamp < b.stamp; });
  std::vector<double> translations;
  std::vector<double> rotations;
  for (const Relation& relation : relations) {
    const auto from = PoseAt(sorted, relation.from_stamp, max_time_difference);
    const auto to = PoseAt(sorted, relation.to_stamp, max_time_difference);
    if (!from || !to) continue;
    const Eigen::Isometry3d error = relation.T_from_to.inverse() * (from->inverse() * *to);
    translations.push_back(error.translation().norm());
    rotations.push_back(Eigen::AngleAxisd(error.linear()).angle());
  }
  if (translations.empty()) {
    throw UserError(place,
                    "none of the " + std::to_string(relations.size()) +
                        " relations has its stamps among those of the " + std::to_string(sorted.size()) + " poses",
                    "check that both are of the same recording, or allow a larger time difference");
  }
  const Spread translation = SpreadOf(translations);
  const Spread rotation = SpreadOf(rotations);
  return {translations.size(), relations.size(), translation.mean, translation.sd,
          translation.max,     rotation.mean,    rotation.sd,      rotation.max};
}

}  // namespace arborslam
