#include "backend/window/sliding_window.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

Eigen::Matrix3d Diagonal(double x, double y, double theta) { return Eigen::Vector3d(x, y, theta).asDiagonal(); }

// The Hessian of a window's cost at its present poses, by central differences of the error's own definition; in the
// order of `nodes`.
struct DenseProblem {
  std::vector<NodeId> nodes;
  std::vector<std::pair<NodeId, Eigen::Matrix3d>> priors;
  std::vector<Constraint> constraints;

  Eigen::Index Column(NodeId node) const { return 3 * (std::find(nodes.begin(), nodes.end(), node) - nodes.begin()); }

  Eigen::MatrixXd Hessian(const SlidingWindow& window) const {
    const auto size = 3 * static_cast<Eigen::Index>(nodes.size());
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    for (const auto& [node, information] : priors) {
      hessian.block<3, 3>(Column(node), Column(node)) += information;
    }
    for (const Constraint& constraint : constraints) {
      const auto error = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        const SE2 T_from_to = SE2(a.x(), a.y(), a.z()).Inverse() * SE2(b.x(), b.y(), b.z());
        return (constraint.T_from_to.Inverse() * T_from_to).vector();
      };
      const Eigen::Vector3d a = window.Pose(constraint.from).vector();
      const Eigen::Vector3d b = window.Pose(constraint.to).vector();
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, size);
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(i);
        jacobian.col(Column(constraint.from) + i) = (error(a + step, b) - error(a - step, b)) / 2e-6;
        jacobian.col(Column(constraint.to) + i) = (error(a, b + step) - error(a, b - step)) / 2e-6;
      }
      hessian += jacobian.transpose() * constraint.information * jacobian;
    }
    return hessian;
  }
};

// Keyframes and submaps with random measurements between them, each consistent with the poses up to noise.
struct RandomWindow {
  SlidingWindow window;
  DenseProblem dense;

  explicit RandomWindow(uint64_t seed) {
    Random random(seed);
    std::vector<SE2> poses;
    for (int i = 0; i < 8; ++i) {
      dense.nodes.push_back(i < 6 ? NodeId(KeyframeId{i}) : NodeId(SubmapId{i - 6}));
      poses.push_back(RandomPose(&random, 5.0));
      window.AddNode(dense.nodes.back(), Disturbed(poses.back(), Diagonal(100.0, 100.0, 1e4), 1.0, &random));
    }
    dense.priors.emplace_back(dense.nodes[0], RandomInformation(&random, 0.1, 0.1));
    window.AddPrior(dense.nodes[0], dense.priors[0].second);
    for (size_t i = 0; i < poses.size(); ++i) {
      for (size_t j = i + 1; j < poses.size(); ++j) {
        if (j > i + 1 && random.Uniform() < 0.5) continue;
        const Eigen::Matrix3d information = RandomInformation(&random, 0.05, 0.02);
        dense.constraints.push_back({dense.nodes[i], dense.nodes[j],
                                     Disturbed(poses[i].Inverse() * poses[j], information, 1.0, &random), information,
                                     Constraint::Kind::kSubmap});
        window.AddConstraint(dense.constraints.back());
      }
    }
  }
};

TEST(SlidingWindow, CovariancesAreThoseOfTheDenseInverse) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    RandomWindow random(seed);
    random.window.Solve();
    const Eigen::MatrixXd covariance = random.dense.Hessian(random.window).inverse();
    for (const NodeId node : random.dense.nodes) {
      const Eigen::Index column = random.dense.Column(node);
      EXPECT_TRUE(random.window.Covariance(node).isApprox(covariance.block<3, 3>(column, column), 1e-5)) << node;
    }
  }
}

TEST(SlidingWindow, MarginalisingKeepsMinimumAndCovariancesOfTheRest) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    RandomWindow random(seed);
    random.window.Solve();
    std::vector<NodeId> order = random.dense.nodes;
    std::rotate(order.begin(), order.begin() + static_cast<int>(seed % order.size()), order.end());
    const Eigen::MatrixXd covariance = random.dense.Hessian(random.window).inverse();
    const std::map<NodeId, SE2> minimum = random.window.poses();
    while (order.size() > 1) {
      random.window.Marginalize(order.back());
      EXPECT_FALSE(random.window.Has(order.back()));
      order.pop_back();
      random.window.Solve();
      for (const NodeId node : order) {
        EXPECT_TRUE(random.window.Pose(node).IsApprox(minimum.at(node), 1e-4)) << node << " of " << order.size();
        const Eigen::Index column = random.dense.Column(node);
        EXPECT_TRUE(random.window.Covariance(node).isApprox(covariance.block<3, 3>(column, column), 1e-4)) << node;
      }
    }
  }
}

// A problem that is linear in all poses: every pose has a dense prior of its own, and measurements know only headings.
struct LinearStep {
  SE2 initial;
  Eigen::Matrix3d prior;
  std::vector<Constraint> constraints;
};

std::vector<LinearStep> LinearProblem(int length, uint64_t seed) {
  Random random(seed);
  std::vector<LinearStep> steps;
  for (int i = 0; i < length; ++i) {
    LinearStep step{
        SE2(random.Gaussian(), random.Gaussian(), 0.3 * random.Gaussian()), RandomInformation(&random, 1.0, 0.3), {}};
    for (int back = 1; back <= 2 && back <= i; ++back) {
      step.constraints.push_back({KeyframeId{i - back}, KeyframeId{i}, SE2(0.0, 0.0, 0.1 * random.Gaussian()),
                                  Diagonal(0.0, 0.0, random.Uniform(10.0, 1000.0)), Constraint::Kind::kMotion});
    }
    steps.push_back(step);
  }
  return steps;
}

TEST(SlidingWindow, ItsLengthDoesNotChangeALinearProblem) {
  const int length = 40;
  for (uint64_t seed = 0; seed < 5; ++seed) {
    const std::vector<LinearStep> steps = LinearProblem(length, seed);
    const KeyframeId last{length - 1};
    SlidingWindow all;
    for (const int num_keyframes : {length, 15, 5, 3}) {
      SlidingWindow window;
      for (int i = 0; i < length; ++i) {
        const LinearStep& step = steps[static_cast<size_t>(i)];
        window.AddNode(KeyframeId{i}, step.initial);
        window.AddPrior(KeyframeId{i}, step.prior);
        for (const Constraint& constraint : step.constraints) window.AddConstraint(constraint);
        // Every other pose leaves before it was ever solved for: the linearisation point does not matter either.
        if (i % 2 == 0) window.Solve();
        if (i >= num_keyframes) window.Marginalize(KeyframeId{i - num_keyframes});
      }
      window.Solve();
      if (num_keyframes == length) all = window;
      ASSERT_EQ(window.poses().size(), static_cast<size_t>(num_keyframes));
      EXPECT_TRUE(window.Pose(last).IsApprox(all.Pose(last), 1e-8)) << num_keyframes << window.Pose(last);
      EXPECT_TRUE(window.Covariance(last).isApprox(all.Covariance(last), 1e-8)) << num_keyframes;
    }
  }
}

// A robot that turns round and round, submaps that overlap, and exact measurements from wrong initial poses.
void Drive(int length, int num_keyframes, SlidingWindow* window, size_t* most_poses, size_t* most_factors) {
  const Eigen::Matrix3d information = Diagonal(1e4, 1e4, 1e5);
  const SE2 step(0.28, 0.0, 0.1);
  std::vector<SE2> truth{SE2()};
  std::vector<int> open;
  for (int i = 0; i < length; ++i) {
    const KeyframeId id{i};
    if (i > 0) truth.push_back(truth.back() * step);
    window->AddNode(id, i == 0 ? truth[0] : window->Pose(KeyframeId{i - 1}) * SE2(0.2, 0.05, 0.15));
    if (i == 0) window->AddPrior(id, Diagonal(1e6, 1e6, 1e6));
    if (i > 0) window->AddConstraint({KeyframeId{i - 1}, id, step, Diagonal(100, 100, 100), Constraint::Kind::kMotion});
    for (const int begun : open) {
      window->AddConstraint({SubmapId{begun / 20}, id, truth[static_cast<size_t>(begun)].Inverse() * truth.back(),
                             information, Constraint::Kind::kSubmap});
    }
    if (i % 20 == 0) {
      window->AddNode(SubmapId{i / 20}, window->Pose(id));
      window->AddConstraint(
          {SubmapId{i / 20}, id, SE2(), 1e8 * Eigen::Matrix3d::Identity(), Constraint::Kind::kSubmap});
      open.push_back(i);
    }
    window->Solve();
    if (i >= num_keyframes) window->Marginalize(KeyframeId{i - num_keyframes});
    if (open.size() > 2) {
      window->Marginalize(SubmapId{open.front() / 20});
      open.erase(open.begin());
    }
    *most_poses = std::max(*most_poses, window->poses().size());
    *most_factors = std::max(*most_factors, window->num_factors());
    ASSERT_TRUE(window->Pose(id).IsApprox(truth.back(), 1e-4)) << id.value << window->Pose(id) << truth.back();
  }
}

TEST(SlidingWindow, ExactMeasurementsGiveTheTruthForAnyLength) {
  for (const int num_keyframes : {2, 3, 5, 15, 50}) {
    SlidingWindow window;
    size_t most_poses = 0;
    size_t most_factors = 0;
    Drive(100, num_keyframes, &window, &most_poses, &most_factors);
  }
}

TEST(SlidingWindow, DoesNotGrowWithTheRun) {
  SlidingWindow window;
  size_t most_poses = 0;
  size_t most_factors = 0;
  Drive(100, 15, &window, &most_poses, &most_factors);
  SlidingWindow longer;
  size_t most_poses_longer = 0;
  size_t most_factors_longer = 0;
  Drive(500, 15, &longer, &most_poses_longer, &most_factors_longer);
  EXPECT_EQ(most_poses, 15u + 2u);
  EXPECT_EQ(most_poses_longer, most_poses);
  EXPECT_EQ(most_factors_longer, most_factors);
  // Per keyframe one motion and two submaps, and one marginal prior for all that left.
  EXPECT_LE(most_factors, 3u * 16u + 2u);
}

TEST(SlidingWindow, IsDeterministicAndCopiesAreIndependent) {
  RandomWindow a(3);
  RandomWindow b(3);
  const SlidingWindow before = a.window;
  a.window.Solve();
  a.window.Marginalize(KeyframeId{2});
  a.window.Solve();
  b.window.Solve();
  b.window.Marginalize(KeyframeId{2});
  b.window.Solve();
  for (const auto& [node, pose] : a.window.poses()) EXPECT_EQ(pose.vector(), b.window.Pose(node).vector()) << node;
  RandomWindow untouched(3);
  EXPECT_EQ(before.num_factors(), untouched.window.num_factors());
  for (const auto& [node, pose] : untouched.window.poses()) EXPECT_EQ(before.Pose(node).vector(), pose.vector());
}

TEST(SlidingWindow, APoseWithoutFactorsLeavesNothingBehind) {
  SlidingWindow window;
  window.AddNode(KeyframeId{0}, SE2(1.0, 2.0, 3.0));
  window.AddNode(KeyframeId{1}, SE2(4.0, 5.0, 0.5));
  window.AddPrior(KeyframeId{1}, Diagonal(1.0, 1.0, 1.0));
  window.Solve();
  EXPECT_TRUE(window.Pose(KeyframeId{0}).IsApprox(SE2(1.0, 2.0, 3.0)));
  window.Marginalize(KeyframeId{0});
  EXPECT_EQ(window.num_factors(), 1u);
  EXPECT_TRUE(window.Pose(KeyframeId{1}).IsApprox(SE2(4.0, 5.0, 0.5)));
}

TEST(SlidingWindow, TheLastPoseLeavesAnEmptyWindowThatCanBeUsedAgain) {
  SlidingWindow window;
  window.Solve();
  window.AddNode(KeyframeId{0}, SE2());
  window.AddPrior(KeyframeId{0}, Diagonal(1.0, 1.0, 1.0));
  window.Marginalize(KeyframeId{0});
  EXPECT_TRUE(window.poses().empty());
  EXPECT_EQ(window.num_factors(), 0u);
  window.Solve();
  window.AddNode(KeyframeId{0}, SE2(1.0, 0.0, 0.0));
  EXPECT_TRUE(window.Pose(KeyframeId{0}).IsApprox(SE2(1.0, 0.0, 0.0)));
}

TEST(SlidingWindow, AnUnknownDirectionOfTheLeavingPoseStaysUnknown) {
  // B is known from A but for its x; C from B. When B leaves, nobody knows C's x, and all else is as before. (What
  // comes later agrees with where they happen to be, so that the point of linearisation is the same.)
  const auto build = [] {
    SlidingWindow window;
    window.AddNode(KeyframeId{0}, SE2());
    window.AddNode(KeyframeId{1}, SE2(1.5, 0.1, 0.0));
    window.AddNode(KeyframeId{2}, SE2(2.5, 0.2, 0.0));
    window.AddPrior(KeyframeId{0}, Diagonal(100.0, 100.0, 100.0));
    window.AddConstraint(
        {KeyframeId{0}, KeyframeId{1}, SE2(1.0, 0.0, 0.0), Diagonal(0.0, 50.0, 80.0), Constraint::Kind::kSubmap});
    window.AddConstraint(
        {KeyframeId{1}, KeyframeId{2}, SE2(1.0, 0.0, 0.0), Diagonal(70.0, 60.0, 90.0), Constraint::Kind::kSubmap});
    window.Solve();
    return window;
  };
  SlidingWindow window = build();
  window.Marginalize(KeyframeId{1});
  EXPECT_TRUE(std::isinf(window.Covariance(KeyframeId{2})(0, 0)));
  EXPECT_TRUE(window.Covariance(KeyframeId{0}).isApprox(0.01 * Eigen::Matrix3d::Identity(), 1e-6));
  SlidingWindow full = build();
  for (SlidingWindow* each : {&window, &full}) {
    each->AddNode(KeyframeId{3}, SE2(3.0, 0.0, 0.0));
    each->AddPrior(KeyframeId{3}, Diagonal(5.0, 5.0, 5.0));
    each->AddConstraint(
        {KeyframeId{3}, KeyframeId{2}, SE2(-0.5, 0.0, 0.0), Diagonal(10.0, 10.0, 10.0), Constraint::Kind::kLoop});
    each->Solve();
  }
  EXPECT_NEAR(window.Pose(KeyframeId{2}).x(), 2.5, 1e-6);
  for (const int i : {0, 2, 3}) {
    EXPECT_TRUE(window.Pose(KeyframeId{i}).IsApprox(full.Pose(KeyframeId{i}), 1e-6)) << i;
    EXPECT_TRUE(window.Covariance(KeyframeId{i}).isApprox(full.Covariance(KeyframeId{i}), 1e-5)) << i;
  }
}

TEST(SlidingWindow, ALeavingPoseThatIsFreeInADirectionPassesOnTheOthers) {
  // B hangs on A and C, but nothing knows its y.
  SlidingWindow window;
  for (int i = 0; i < 3; ++i) window.AddNode(KeyframeId{i}, SE2(i, 0.0, 0.0));
  window.AddPrior(KeyframeId{0}, Diagonal(100.0, 100.0, 100.0));
  const Eigen::Matrix3d no_y = Diagonal(100.0, 0.0, 100.0);
  window.AddConstraint({KeyframeId{0}, KeyframeId{1}, SE2(1.0, 0.0, 0.0), no_y, Constraint::Kind::kSubmap});
  window.AddConstraint({KeyframeId{1}, KeyframeId{2}, SE2(1.0, 0.0, 0.0), no_y, Constraint::Kind::kSubmap});
  window.AddPrior(KeyframeId{2}, Diagonal(0.0, 1.0, 0.0));
  window.Marginalize(KeyframeId{1});
  const Eigen::Matrix3d covariance = window.Covariance(KeyframeId{2});
  EXPECT_NEAR(covariance(0, 0), 0.03, 1e-6);
  EXPECT_NEAR(covariance(1, 1), 1.0, 1e-6);
  EXPECT_NEAR(covariance(2, 2), 0.03, 1e-6);
}

TEST(SlidingWindow, CovarianceIsInfiniteWithoutAPrior) {
  SlidingWindow window;
  window.AddNode(KeyframeId{0}, SE2());
  window.AddNode(KeyframeId{1}, SE2(1.0, 0.0, 0.0));
  window.AddConstraint(
      {KeyframeId{0}, KeyframeId{1}, SE2(1.0, 0.0, 0.1), Diagonal(1.0, 1.0, 1.0), Constraint::Kind::kMotion});
  window.Solve();
  EXPECT_TRUE(std::isinf(window.Covariance(KeyframeId{1})(2, 2)));
  const SE2 T_0_1 = window.Pose(KeyframeId{0}).Inverse() * window.Pose(KeyframeId{1});
  EXPECT_TRUE(T_0_1.IsApprox(SE2(1.0, 0.0, 0.1), 1e-6));
}

TEST(SlidingWindowDeathTest, MisuseIsNamed) {
  SlidingWindow window;
  window.AddNode(KeyframeId{7}, SE2());
  window.AddNode(KeyframeId{8}, SE2());
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  EXPECT_DEATH(window.AddNode(KeyframeId{7}, SE2()), "keyframe 7 is in the window already");
  EXPECT_DEATH(window.Marginalize(SubmapId{7}), "submap 7");
  EXPECT_DEATH(window.AddPrior(KeyframeId{9}, unit), "keyframe 9");
  EXPECT_DEATH(window.AddConstraint({KeyframeId{7}, SubmapId{0}, SE2(), unit, Constraint::Kind::kMotion}), "submap 0");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DEATH(window.AddConstraint({KeyframeId{7}, KeyframeId{8}, SE2(), nan * unit, Constraint::Kind::kMotion}),
               "keyframe 7 to keyframe 8 is not finite");
}

}  // namespace
}  // namespace arborslam
