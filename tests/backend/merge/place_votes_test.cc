#include "backend/merge/place_votes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/map/occupancy_grid.h"
#include "tests/backend/planar_posts.h"

namespace arborslam {
namespace {

// The map of a run among posts, exact, its frame turned and moved by T_map_world.
SessionContents MapOfPosts(const std::vector<Eigen::Vector2d>& posts, const std::vector<SE2>& path,
                           const SE2& T_map_world) {
  PostsRun run(posts, path);
  const auto last = static_cast<int>(path.size()) - 1;
  run.AddSubmap(0, last / 2, OccupancyGridOptions());
  run.AddSubmap(last / 2, last, OccupancyGridOptions());
  SessionContents map;
  for (size_t i = 0; i < path.size(); ++i) map.graph.AddNode(run.keyframes[i].id, T_map_world * path[i]);
  for (const Submap& submap : run.submaps) map.graph.AddNode(submap.id, T_map_world * run.TruthOf(submap));
  map.keyframes = run.keyframes;
  map.submaps = run.submaps;
  return map;
}

std::vector<SE2> Line(int count, double y, double theta) {
  std::vector<SE2> path;
  for (int i = 0; i < count; ++i) {
    const double x = -8.0 + 0.5 * i;
    path.emplace_back(theta == 0.0 ? x : -x, y, theta);
  }
  return path;
}

PlaceVotes Vote(const SessionContents& a, const SessionContents& b, const MergeOptions& merge = MergeOptions()) {
  return VoteOnPlace(SlamOptions(), merge, a, b, 2);
}

TEST(VoteOnPlaceTest, FindsTheFrameOfAnotherMapOfTheSamePosts) {
  const std::vector<Eigen::Vector2d> posts = StrewnPosts(60, 40.0, 5);
  const SE2 T_a_world(100.0, -30.0, 2.0);
  const SE2 T_b_world(-7.0, 4.0, -1.0);
  const SessionContents a = MapOfPosts(posts, Line(33, 0.0, 0.0), T_a_world);
  const SessionContents b = MapOfPosts(posts, Line(33, 1.0, 3.1), T_b_world);
  MergeOptions options;
  options.spacing = 0.9;
  const PlaceVotes votes = Vote(a, b, options);
  EXPECT_EQ(votes.reason, "");
  // Every second keyframe: they are 0.5 m apart.
  EXPECT_EQ(votes.num_asked, 17u);
  EXPECT_GE(votes.agreeing.size(), 8u);
  EXPECT_EQ(votes.num_rivals, votes.num_recognized - votes.agreeing.size());
  EXPECT_TRUE(votes.T_a_b.IsApprox(T_a_world * T_b_world.Inverse(), 0.02)) << votes.T_a_b;
  for (const PlaceVote& vote : votes.agreeing) {
    EXPECT_TRUE((votes.T_a_b * vote.T_b_keyframe).IsApprox(vote.T_a_keyframe, 0.1)) << vote.keyframe.value;
    EXPECT_TRUE((a.graph.Pose(vote.submap) * vote.match.pose).IsApprox(vote.T_a_keyframe, 1e-9));
  }
}

TEST(VoteOnPlaceTest, OtherPostsAreNotTakenForThese) {
  const SessionContents a = MapOfPosts(StrewnPosts(60, 40.0, 5), Line(33, 0.0, 0.0), SE2());
  const SessionContents b = MapOfPosts(StrewnPosts(60, 40.0, 6), Line(33, 0.0, 0.0), SE2());
  EXPECT_EQ(Vote(a, b).reason, "too few agree");
  EXPECT_EQ(Vote(a, SessionContents()).reason, "too few agree");
}

TEST(VoteOnPlaceTest, AMapTornInTwoAgreesOnTwoPlaces) {
  // The second half of the other map lies a tree's distance off.
  const std::vector<Eigen::Vector2d> posts = StrewnPosts(60, 40.0, 5);
  const SessionContents a = MapOfPosts(posts, Line(33, 0.0, 0.0), SE2());
  SessionContents b = MapOfPosts(posts, Line(33, 1.0, 3.1), SE2());
  for (int i = 17; i < 33; ++i) b.graph.SetPose(KeyframeId{i}, SE2(2.0, 0.0, 0.0) * b.graph.Pose(KeyframeId{i}));
  MergeOptions options;
  options.min_votes = 2;
  const PlaceVotes votes = Vote(a, b, options);
  EXPECT_GE(votes.num_rivals, 2u);
  EXPECT_EQ(votes.reason, "too many agree on another place");
}

TEST(VoteOnPlaceTest, MoreVotesThanThereAreAreTooMany) {
  const std::vector<Eigen::Vector2d> posts = StrewnPosts(60, 40.0, 5);
  const SessionContents a = MapOfPosts(posts, Line(33, 0.0, 0.0), SE2());
  const SessionContents b = MapOfPosts(posts, Line(33, 1.0, 3.1), SE2());
  MergeOptions options;
  options.min_votes = 18;
  EXPECT_EQ(Vote(a, b, options).reason, "too few agree");
}

TEST(PlaceVotesTest, AreToldInOneLine) {
  PlaceVotes votes;
  votes.num_asked = 21;
  votes.num_recognized = 20;
  votes.agreeing.resize(19);
  EXPECT_EQ(TextOf(votes), "21 keyframes asked, 20 recognised a place, 19 agree on one, 0 on another");
  EXPECT_EQ(TextOf(SE2(1.25, -3.0, 0.5)), "(1.250 m, -3.000 m, 0.5000 rad)");
}

TEST(MergeOptionsTest, NamesWhatIsOutOfRange) {
  EXPECT_EQ(MergeOptions().Validate(), "");
  const auto problem = [](auto&& change) {
    MergeOptions options;
    change(&options);
    return options.Validate();
  };
  EXPECT_EQ(problem([](MergeOptions* o) { o->spacing = -1.0; }).rfind("spacing", 0), 0u);
  EXPECT_EQ(problem([](MergeOptions* o) { o->min_votes = 1; }).rfind("min_votes", 0), 0u);
  EXPECT_EQ(problem([](MergeOptions* o) { o->min_ratio = 0.5; }).rfind("min_ratio", 0), 0u);
  EXPECT_EQ(problem([](MergeOptions* o) { o->vote_translation = 0.0; }).rfind("vote_translation", 0), 0u);
  EXPECT_EQ(problem([](MergeOptions* o) { o->vote_rotation = 0.0; }).rfind("vote_rotation", 0), 0u);
}

}  // namespace
}  // namespace arborslam
