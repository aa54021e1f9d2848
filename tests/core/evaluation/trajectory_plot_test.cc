#include "core/evaluation/trajectory_plot.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/error.h"
#include "core/geometry/angles.h"

#ifdef __SANITIZE_ADDRESS__
// Fontconfig loses one pattern for each font that cairo loads, once a process: not ours to mend.
extern "C" {
const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }
const char* __lsan_default_options();
const char* __lsan_default_options() { return "print_suppressions=0"; }
}
#endif

namespace arborslam {
namespace {

constexpr char kPngSignature[] = "\x89PNG\r\n\x1a\n";
constexpr char kPngEnd[] = "IEND\xae\x42\x60\x82";

struct Size {
  int width, height;
};

// From the header chunk, which a PNG begins with.
Size SizeOf(const std::string& png) {
  EXPECT_EQ(png.substr(0, 8), kPngSignature);
  EXPECT_EQ(png.substr(12, 4), "IHDR");
  EXPECT_EQ(png.substr(png.size() - 8), kPngEnd);
  const auto integer = [&](size_t at) {
    int value = 0;
    for (size_t i = at; i < at + 4; ++i) value = 256 * value + static_cast<unsigned char>(png[i]);
    return value;
  };
  return {integer(16), integer(20)};
}

// An ellipse with the given half axes [m] about (cx, cy), the estimate `error` [m] outside of it in x.
TrajectoryEvaluation Ellipse(int count, double rx, double ry, double error, double cx = 0.0, double cy = 0.0) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < count; ++i) {
    const double t = 2.0 * kPi * i / count;
    PosePair pair;
    pair.reference.position = {cx + rx * std::cos(t), cy + ry * std::sin(t), 0.0};
    pair.estimate.position = pair.reference.position + Eigen::Vector3d(error * std::cos(t), 0.0, 0.0);
    pairs.push_back(pair);
  }
  return EvaluateTrajectory(pairs, false, AlignmentKind::kNone);
}

TEST(TrajectoryPlotTest, HeightFollowsTheShapeOfThePathWithinBounds) {
  const Size round = SizeOf(RenderTrajectoryPlot(Ellipse(100, 10.0, 6.0, 0.3), {"run"}));
  const Size wide = SizeOf(RenderTrajectoryPlot(Ellipse(100, 1000.0, 1.0, 0.3), {"run"}));
  const Size tall = SizeOf(RenderTrajectoryPlot(Ellipse(100, 1.0, 1000.0, 0.3), {"run"}));
  EXPECT_EQ(round.width, 1000);
  EXPECT_EQ(wide.width, 1000);
  EXPECT_EQ(tall.width, 1000);
  EXPECT_LT(wide.height, round.height);
  EXPECT_LT(round.height, tall.height);
  EXPECT_GE(wide.height, 500);
  EXPECT_LE(tall.height, 1200);
}

TEST(TrajectoryPlotTest, IsDeterministicAndShowsTheData) {
  const std::string png = RenderTrajectoryPlot(Ellipse(50, 10.0, 6.0, 0.3), {"run"});
  EXPECT_EQ(png, RenderTrajectoryPlot(Ellipse(50, 10.0, 6.0, 0.3), {"run"}));
  EXPECT_NE(png, RenderTrajectoryPlot(Ellipse(50, 10.0, 6.0, 0.6), {"run"}));
  EXPECT_NE(png, RenderTrajectoryPlot(Ellipse(50, 10.0, 6.0, 0.3), {"nur"}));
}

TEST(TrajectoryPlotTest, DegenerateDataIsDrawnNonetheless) {
  for (const int count : {1, 2, 3}) {
    EXPECT_EQ(SizeOf(RenderTrajectoryPlot(Ellipse(count, 0.0, 0.0, 0.0), {""})).width, 1000) << count;
    EXPECT_EQ(SizeOf(RenderTrajectoryPlot(Ellipse(count, 1.0, 0.0, 0.0), {""})).width, 1000) << count;
    EXPECT_EQ(SizeOf(RenderTrajectoryPlot(Ellipse(count, 1e-9, 1e-9, 1e9), {""})).width, 1000) << count;
    EXPECT_EQ(SizeOf(RenderTrajectoryPlot(Ellipse(count, 9e8, 9e8, 1.0), {""})).width, 1000) << count;
    EXPECT_EQ(SizeOf(RenderTrajectoryPlot(Ellipse(count, 1e-3, 0.0, 1e-12, 5e8, -6.3e6), {""})).width, 1000) << count;
  }
}

TEST(TrajectoryPlotTest, AnyFileNameServesAsTitle) {
  for (const std::string& title :
       {std::string(5000, 'x'), std::string("\xff\xfe\x00\n", 4), std::string("Stra\xc3\x9f")}) {
    EXPECT_EQ(SizeOf(RenderTrajectoryPlot(Ellipse(10, 10.0, 6.0, 0.3), {title})).width, 1000);
  }
}

TEST(TrajectoryPlotTest, WritesTheFileWholeOrNotAtAll) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("trajectory_plot_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const TrajectoryEvaluation evaluation = Ellipse(20, 10.0, 6.0, 0.3);
  const std::string path = (folder / "plot.png").string();
  WriteTrajectoryPlot(path, evaluation, {"run"});
  std::ifstream file(path, std::ios::binary);
  const std::string written{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(written, RenderTrajectoryPlot(evaluation, {"run"}));
  EXPECT_THROW(WriteTrajectoryPlot((folder / "none" / "plot.png").string(), evaluation, {"run"}), UserError);
  const auto count = std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
  EXPECT_EQ(count, 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace arborslam
