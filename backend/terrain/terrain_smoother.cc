#include "backend/terrain/terrain_smoother.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "core/config/validation.h"
#include "frontend/tracking/terrain_fit.h"

namespace arborslam {
namespace {

constexpr int kIterations = 3;
// [m], roughness of ground, and distance at which a sample's weight has fallen to a half.
constexpr double kRoughness = 0.05;
constexpr double kRobustScale = 0.15;
// [m], standard deviation of the difference in height of neighbouring nodes, per metre between them.
constexpr double kNodeSlope = 0.3;
// [m], of the first view's height, which fixes the level of the map.
constexpr double kAnchorSigma = 1e-3;

// Nodes of the range bias, the first unknowns, and the standard deviations [m] of the first and of the step from one
// to the next.
constexpr int kNumBiasNodes = 6;
constexpr double kBiasSigma = 1e-3;
constexpr double kBiasStep = 0.05;
// [rad], of a sample about the lidar, since it rocks during the sweep.
constexpr double kRocking = 0.01;

// A sample's height as a mixture of unknowns: the four terrain nodes around it and the two bias nodes by its range.
constexpr size_t kMixed = 6;
struct Mixture {
  std::array<int, kMixed> nodes;
  std::array<double, kMixed> shares;
};

// The two bias nodes around `range` [m], and the second's share.
std::pair<int, double> BiasNode(double range) {
  const double place = std::min(range / RangeBias::kSpacing, static_cast<double>(kNumBiasNodes - 1));
  const int node = std::min(static_cast<int>(place), kNumBiasNodes - 2);
  return {node, place - static_cast<double>(node)};
}

class NodeGrid {
 public:
  explicit NodeGrid(double spacing) : spacing_(spacing) {}

  // Of a sample at `position` [m] that was seen from `range` [m].
  Mixture At(const Eigen::Vector2d& position, double range) {
    const Eigen::Vector2d cell = position / spacing_;
    const auto x = static_cast<int64_t>(std::floor(cell.x()));
    const auto y = static_cast<int64_t>(std::floor(cell.y()));
    const double u = cell.x() - static_cast<double>(x);
    const double v = cell.y() - static_cast<double>(y);
    const auto [bias, share] = BiasNode(range);
    return {{Node(x, y), Node(x + 1, y), Node(x, y + 1), Node(x + 1, y + 1), bias, bias + 1},
            {(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v, 1.0 - share, share}};
  }

  // Unknowns, with those of the bias.
  int size() const { return kNumBiasNodes + static_cast<int>(numbers_.size()); }

  // Pairs of nodes beside each other.
  std::vector<std::pair<int, int>> Neighbors() const {
    std::vector<std::pair<int, int>> pairs;
    for (const auto& [place, number] : numbers_) {
      for (const auto& [dx, dy] : {std::pair<int, int>{1, 0}, std::pair<int, int>{0, 1}}) {
        const auto found = numbers_.find({place.first + dx, place.second + dy});
        if (found != numbers_.end()) pairs.push_back({number, found->second});
      }
    }
    return pairs;
  }

 private:
  int Node(int64_t x, int64_t y) { return numbers_.emplace(std::make_pair(x, y), size()).first->second; }

  double spacing_;
  std::map<std::pair<int64_t, int64_t>, int> numbers_;
};

// One view's part of the normal equations, its own unknowns (turns about base's x and y, z) eliminated.
struct ViewSystem {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  std::vector<int> nodes;    // That the view sees, ascending.
  Eigen::MatrixXd coupling;  // 3 x nodes.
  Eigen::MatrixXd node_information;
  Eigen::VectorXd node_vector;
};

// A sparse symmetric matrix, as its lower triangle, that is a sum of very many entries.
class SymmetricSum {
 public:
  explicit SymmetricSum(int size) : sum_(size, size) {}

  // `row` must not be less than `column`.
  void Add(int row, int column, double value) {
    entries_.emplace_back(row, column, value);
    if (entries_.size() >= kMostEntries) Gather();
  }

  const Eigen::SparseMatrix<double>& Get() {
    Gather();
    return sum_;
  }

 private:
  // As many as are not added up yet at most: all would take several times the memory of the sum.
  static constexpr size_t kMostEntries = size_t{1} << 20;

  void Gather() {
    Eigen::SparseMatrix<double> gathered(sum_.rows(), sum_.cols());
    gathered.setFromTriplets(entries_.begin(), entries_.end());
    sum_ += gathered;
    entries_.clear();
  }

  Eigen::SparseMatrix<double> sum_;
  std::vector<Eigen::Triplet<double>> entries_;
};

// The mean of the ground that the views see, by node.
Eigen::VectorXd InitialHeights(const std::vector<TerrainView>& views, const std::vector<std::vector<Mixture>>& mixtures,
                               int num_nodes) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(num_nodes);
  Eigen::VectorXd shares = Eigen::VectorXd::Constant(num_nodes, 1e-9);
  for (size_t i = 0; i < views.size(); ++i) {
    const Eigen::Isometry3d T_base_lidar = views[i].tilt.Transform();
    const std::shared_ptr<const std::vector<GroundSample>> samples = views[i].samples.Get();
    for (size_t j = 0; j < samples->size(); ++j) {
      const double z = (T_base_lidar * (*samples)[j].position.cast<double>()).z();
      for (size_t k = 0; k < 4; ++k) {
        sums[mixtures[i][j].nodes[k]] += mixtures[i][j].shares[k] * z;
        shares[mixtures[i][j].nodes[k]] += mixtures[i][j].shares[k];
      }
    }
  }
  Eigen::VectorXd heights = sums.cwiseQuotient(shares);
  heights.head<kNumBiasNodes>().setZero();
  return heights;
}

ViewSystem Linearize(const TerrainView& view, const std::vector<Mixture>& mixtures, const Eigen::VectorXd& heights,
                     const TerrainOptions& options) {
  ViewSystem system;
  for (const Mixture& mixture : mixtures) {
    system.nodes.insert(system.nodes.end(), mixture.nodes.begin(), mixture.nodes.end());
  }
  std::sort(system.nodes.begin(), system.nodes.end());
  system.nodes.erase(std::unique(system.nodes.begin(), system.nodes.end()), system.nodes.end());
  const auto num_nodes = static_cast<Eigen::Index>(system.nodes.size());
  system.coupling = Eigen::MatrixXd::Zero(3, num_nodes);
  system.node_information = Eigen::MatrixXd::Zero(num_nodes, num_nodes);
  system.node_vector = Eigen::VectorXd::Zero(num_nodes);

  const double slope_information = 1.0 / (options.slope_sigma * options.slope_sigma);
  system.information.diagonal() << slope_information, slope_information, 0.0;
  system.vector << slope_information * (view.local_tilt.roll - view.tilt.roll),
      slope_information * (view.local_tilt.pitch - view.tilt.pitch), 0.0;
  const Eigen::Matrix3d rotation = view.tilt.Rotation();
  const std::shared_ptr<const std::vector<GroundSample>> samples = view.samples.Get();
  for (size_t i = 0; i < samples->size(); ++i) {
    const Eigen::Vector3d point = rotation * (*samples)[i].position.cast<double>();
    const Mixture& mixture = mixtures[i];
    std::array<Eigen::Index, kMixed> local{};
    double ground = 0.0;
    for (size_t k = 0; k < kMixed; ++k) {
      local[k] = std::lower_bound(system.nodes.begin(), system.nodes.end(), mixture.nodes[k]) - system.nodes.begin();
      ground += mixture.shares[k] * heights[mixture.nodes[k]];
    }
    const double residual = view.tilt.z + point.z() - ground;
    const double ratio = residual / kRobustScale;
    const double rocking = kRocking * kRocking * point.head<2>().squaredNorm();
    const double weight = 1.0 / ((kRoughness * kRoughness + rocking) * (1.0 + ratio * ratio));
    const Eigen::Vector3d jacobian(point.y(), -point.x(), 1.0);
    system.information += weight * jacobian * jacobian.transpose();
    system.vector -= weight * residual * jacobian;
    for (size_t k = 0; k < kMixed; ++k) {
      system.coupling.col(local[k]) -= weight * mixture.shares[k] * jacobian;
      system.node_vector[local[k]] += weight * residual * mixture.shares[k];
      for (size_t l = 0; l < kMixed; ++l) {
        system.node_information(local[k], local[l]) += weight * mixture.shares[k] * mixture.shares[l];
      }
    }
  }
  return system;
}

}  // namespace

std::string TerrainOptions::Validate() const {
  if (!(cell_size >= 0.1 && cell_size <= 20.0)) return Violation("cell_size", cell_size, "lie in [0.1, 20] m");
  if (!(node_spacing >= 0.2 && node_spacing <= 50.0)) {
    return Violation("node_spacing", node_spacing, "lie in [0.2, 50] m");
  }
  if (!(keyframe_spacing >= 0.0)) return Violation("keyframe_spacing", keyframe_spacing, "be at least 0 m");
  if (!(slope_sigma > 0.0)) return Violation("slope_sigma", slope_sigma, "be above 0 rad");
  return "";
}

double RangeBias::At(double range) const {
  if (heights.empty()) return 0.0;
  const auto [node, share] = BiasNode(range);
  const auto first = static_cast<size_t>(node);
  return (1.0 - share) * heights[first] + share * heights[first + 1];
}

std::vector<GroundSample> WithoutBias(const RangeBias& bias, const Tilt3& tilt,
                                      const std::vector<GroundSample>& samples) {
  const Eigen::Matrix3d rotation = tilt.Rotation();
  const Eigen::Vector3f up = rotation.row(2).cast<float>();
  std::vector<GroundSample> lowered = samples;
  for (GroundSample& sample : lowered) {
    const double range = (rotation * sample.position.cast<double>()).head<2>().norm();
    sample.position -= static_cast<float>(bias.At(range)) * up;
  }
  return lowered;
}

SmoothedTerrain SmoothTerrain(const TerrainOptions& options, std::vector<TerrainView>* views) {
  SmoothedTerrain smoothed{TerrainMap(options.cell_size), {}};
  if (views->empty()) return smoothed;
  NodeGrid grid(options.node_spacing);
  std::vector<std::vector<Mixture>> mixtures(views->size());
  for (size_t i = 0; i < views->size(); ++i) {
    const TerrainView& view = (*views)[i];
    const std::shared_ptr<const std::vector<GroundSample>> samples = view.samples.Get();
    for (const GroundSample& sample : *samples) {
      const Eigen::Vector3d point = view.tilt.Rotation() * sample.position.cast<double>();
      const Eigen::Vector2d place = point.head<2>();
      mixtures[i].push_back(grid.At(view.T_map_base * place, place.norm()));
    }
  }
  if (grid.size() == kNumBiasNodes) return smoothed;
  const std::vector<std::pair<int, int>> neighbors = grid.Neighbors();
  const double node_step = kNodeSlope * options.node_spacing;
  const double smoothness = 1.0 / (node_step * node_step);
  const double anchor = 1.0 / (kAnchorSigma * kAnchorSigma);
  const double anchor_height = views->front().tilt.z;

  Eigen::VectorXd heights = InitialHeights(*views, mixtures, grid.size());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::vector<ViewSystem> systems;
    SymmetricSum information(grid.size());
    Eigen::VectorXd vector = Eigen::VectorXd::Zero(grid.size());
    for (size_t i = 0; i < views->size(); ++i) {
      systems.push_back(Linearize((*views)[i], mixtures[i], heights, options));
      ViewSystem& system = systems.back();
      if (i == 0) {
        system.information(2, 2) += anchor;
        system.vector.z() += anchor * (anchor_height - (*views)[i].tilt.z);
      }
      // A view without ground stays as it is.
      if (system.nodes.empty()) continue;
      const Eigen::LDLT<Eigen::Matrix3d> factor(system.information);
      const Eigen::MatrixXd reduced =
          system.node_information - system.coupling.transpose() * factor.solve(system.coupling);
      const Eigen::VectorXd reduced_vector =
          system.node_vector - system.coupling.transpose() * factor.solve(system.vector);
      for (Eigen::Index row = 0; row < reduced.rows(); ++row) {
        const int node = system.nodes[static_cast<size_t>(row)];
        vector[node] += reduced_vector[row];
        for (Eigen::Index col = 0; col <= row; ++col) {
          information.Add(node, system.nodes[static_cast<size_t>(col)], reduced(row, col));
        }
      }
      // The greatest part, needed no more.
      system.node_information.resize(0, 0);
    }
    for (const auto& [a, b] : neighbors) {
      const double difference = heights[a] - heights[b];
      vector[a] -= smoothness * difference;
      vector[b] += smoothness * difference;
      information.Add(a, a, smoothness);
      information.Add(b, b, smoothness);
      information.Add(std::max(a, b), std::min(a, b), -smoothness);
    }
    const double first_bias = 1.0 / (kBiasSigma * kBiasSigma);
    vector[0] -= first_bias * heights[0];
    information.Add(0, 0, first_bias);
    constexpr double kSteadiness = 1.0 / (kBiasStep * kBiasStep);
    for (int node = 1; node < kNumBiasNodes; ++node) {
      const double difference = heights[node] - heights[node - 1];
      vector[node] -= kSteadiness * difference;
      vector[node - 1] += kSteadiness * difference;
      information.Add(node, node, kSteadiness);
      information.Add(node - 1, node - 1, kSteadiness);
      information.Add(node, node - 1, -kSteadiness);
    }
    for (int node = 0; node < grid.size(); ++node) information.Add(node, node, 1e-6);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(information.Get());
    const Eigen::VectorXd step = solver.solve(vector);
    heights += step;
    for (size_t i = 0; i < views->size(); ++i) {
      const ViewSystem& system = systems[i];
      if (system.nodes.empty()) continue;
      Eigen::VectorXd node_step_of_view(static_cast<Eigen::Index>(system.nodes.size()));
      for (size_t k = 0; k < system.nodes.size(); ++k) {
        node_step_of_view[static_cast<Eigen::Index>(k)] = step[system.nodes[k]];
      }
      const Eigen::Vector3d view_step =
          system.information.ldlt().solve(system.vector - system.coupling * node_step_of_view);
      Tilt3& tilt = (*views)[i].tilt;
      tilt.roll += view_step.x();
      tilt.pitch += view_step.y();
      tilt.z += view_step.z();
    }
  }
  smoothed.bias.heights.assign(heights.data(), heights.data() + kNumBiasNodes);
  for (const TerrainView& view : *views) {
    const Eigen::Isometry3d T_map_lidar = Lift(view.T_map_base, view.tilt);
    const std::shared_ptr<const std::vector<GroundSample>> samples = view.samples.Get();
    for (const GroundSample& sample : WithoutBias(smoothed.bias, view.tilt, *samples)) {
      smoothed.terrain.Insert(T_map_lidar * sample.position.cast<double>(), sample.weight);
    }
  }
  return smoothed;
}

}  // namespace arborslam
