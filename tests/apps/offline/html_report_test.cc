// Looks at the report in a real browser, headless Chromium.

#include "apps/offline/html_report.h"

#include <cairo.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "apps/offline/run_figures.h"
#include "core/io/npz.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/planar_orchard.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr double kPi = 3.14159265358979323846;

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Everything a report is made of, by hand: `num_scans` scans once around a circle of 10 m.
struct HandmadeRun {
  RunRecord record;
  std::vector<Submap> submaps;
  std::string config = "tracker:\n  wide_score: 0.1\n";
  Trajectory3 trajectory;
  Trajectory3 odometry;
  std::vector<ScoreGate> gates = {{0.1, "kept out of the maps"}, {0.15, "rejected"}};
  GridImage map;

  explicit HandmadeRun(size_t num_scans) {
    record.input = "somewhere/run.npz";
    for (size_t i = 0; i < num_scans; ++i) {
      const double angle = 2.0 * kPi * static_cast<double>(i) / static_cast<double>(num_scans);
      ScanResult scan;
      scan.stamp = 1.7e9 + 0.1 * static_cast<double>(i);
      scan.status = ScanStatus::kMatched;
      scan.T_odom_base = SE2(10.0 * std::sin(angle) + 0.01 * angle, 10.0 - 10.0 * std::cos(angle), angle);
      scan.match.verdict = i == 0 ? MatchVerdict::kTooFewPoints : MatchVerdict::kAccepted;
      scan.match.score = 0.03 + 0.01 * std::sin(7.0 * angle);
      scan.match.inlier_ratio = 0.9;
      scan.match.num_points = 400;
      scan.is_keyframe = scan.is_inserted = true;
      scan.project_ms = 0.5 + 0.001 * static_cast<double>(i % 77);
      scan.match_ms = 3.123 + 0.01 * static_cast<double>(i % 101);
      scan.window_ms = 0.4;
      scan.insert_ms = 1.2;
      record.scans.push_back(scan);
      const SE2 pose(10.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle), angle);
      trajectory.poses.push_back(ToTrajectory3({{scan.stamp, pose}}).poses.front());
      odometry.poses.push_back(ToTrajectory3({{scan.stamp, scan.T_odom_base}}).poses.front());
    }
    submaps.push_back({SubmapId{0}, {}, {}});
    for (size_t i = 0; i < num_scans / 2; ++i) submaps[0].keyframes.push_back(KeyframeId{static_cast<int>(i)});
    record.num_submaps = 1;
    record.wall_seconds = 2.5;
    map.width = 260;
    map.height = 240;
    map.resolution = 0.1;
    map.origin_x = -13.0;
    map.origin_y = -2.0;
    map.occupancy.assign(static_cast<size_t>(map.width * map.height), 0);
    for (size_t i = 0; i < map.occupancy.size(); i += 97) map.occupancy[i] = 100;
    for (size_t i = 0; i < map.occupancy.size() / 8; ++i) map.occupancy[i] = GridImage::kUnknown;
  }

  // Scan `i` gets no match, for `verdict`.
  void Reject(size_t i, MatchVerdict verdict) {
    ScanResult& scan = record.scans.at(i);
    scan.status = ScanStatus::kPredicted;
    scan.match.verdict = verdict;
    scan.match.score = 0.17;
    scan.reason = ToString(verdict);
    scan.is_inserted = false;
  }

  // Scan `i` gets no pose.
  void Skip(size_t i, const std::string& reason) {
    record.scans.at(i) = ScanResult{};
    record.scans[i].stamp = record.scans.at(i - 1).stamp;
    record.scans[i].reason = reason;
    const double stamp = 1.7e9 + 0.1 * static_cast<double>(i);
    for (Trajectory3* poses : {&trajectory, &odometry}) {
      poses->poses.erase(std::find_if(poses->poses.begin(), poses->poses.end(),
                                      [stamp](const StampedPose3& pose) { return pose.stamp == stamp; }));
    }
  }

  // The map leaves the pose open along the base's x axis at scans first..last.
  void Degenerate(size_t first, size_t last) {
    for (size_t i = first; i <= last; ++i) {
      MatchResult& match = record.scans.at(i).match;
      match.verdict = MatchVerdict::kDegenerate;
      match.num_degenerate = 1;
      match.information = Eigen::Vector3d(0.0, 400.0, 9000.0).asDiagonal();
    }
  }

  void AddLoop(int keyframe, bool accepted, const std::string& reason) {
    LoopCandidate loop;
    loop.keyframe = KeyframeId{keyframe};
    loop.submap = SubmapId{0};
    loop.accepted = accepted;
    loop.reason = reason;
    loop.match.score = 0.04;
    loop.match.inlier_ratio = 0.8;
    record.finish.loops.push_back(loop);
  }

  // The reference has its origin elsewhere.
  void AddErrors(double height = 0.0) {
    Trajectory3 reference = trajectory;
    for (StampedPose3& pose : reference.poses) pose.position += Eigen::Vector3d(100.0, 50.0, height);
    for (size_t i = 0; i < reference.poses.size(); ++i) reference.poses[i].position.x() += i % 2 == 0 ? 0.02 : -0.02;
    const auto evaluate = [&](const Trajectory3& estimate) {
      const AssociationResult pairs = Associate(estimate, reference, AssociationOptions(), "the test");
      return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2);
    };
    record.errors = RunErrors{evaluate(trajectory), evaluate(odometry), 0, LoopErrors{4, 3, 1, 0.2, 0.7}};
  }

  std::string Report(bool with_map = true) const {
    return HtmlReport({record, submaps, config, with_map ? &map : nullptr, trajectory, odometry, gates});
  }
};

// The JSON in the page, as the page reads it.
nlohmann::json DataOf(const std::string& html) {
  const std::string begin = "<script type=\"application/json\" id=\"report-data\">";
  const size_t at = html.find(begin);
  if (at == std::string::npos) return nlohmann::json(nlohmann::json::value_t::discarded);
  const size_t from = at + begin.size();
  return nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from), nullptr, false);
}

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// ---- What needs no browser.

TEST(HtmlReportTest, HoldsTheRun) {
  HandmadeRun run(100);
  run.Reject(10, MatchVerdict::kPoor);
  run.Skip(20, "stamp not after the scan before");
  run.Degenerate(30, 34);
  run.AddLoop(80, true, "");
  run.AddLoop(92, false, "overlap");
  const nlohmann::json data = DataOf(run.Report());
  ASSERT_FALSE(data.is_discarded());
  EXPECT_EQ(data.at("run").at("input"), "somewhere/run.npz");
  const nlohmann::json& scans = data.at("scans");
  for (const char* column : {"index", "t_ms", "score_um", "x_mm", "odometry_y_mm"}) {
    EXPECT_EQ(scans.at(column).size(), 100u) << column;
  }
  std::string fates(100, 'a');
  fates[0] = 'i';
  fates[10] = 'p';
  fates[20] = 'k';
  for (size_t i = 30; i <= 34; ++i) fates[i] = 'd';
  EXPECT_EQ(scans.at("fate"), fates);
  EXPECT_TRUE(scans.at("x_mm").at(20).is_null());
  EXPECT_EQ(scans.at("x_mm").at(25), 10000);
  EXPECT_EQ(scans.at("y_mm").at(50), 20000);
  EXPECT_EQ(scans.at("t_ms").at(99), 9900);
  EXPECT_FALSE(scans.contains("z_mm"));
  EXPECT_FALSE(scans.contains("error_um"));
  EXPECT_FALSE(data.contains("errors"));
  EXPECT_EQ(data.at("unused").at("total"), 2);
  ASSERT_EQ(data.at("stretches").at("rows").size(), 1u);
  const nlohmann::json& stretch = data.at("stretches").at("rows").at(0);
  EXPECT_EQ(stretch.at(0), 30);
  EXPECT_EQ(stretch.at(1), 34);
  EXPECT_NEAR(stretch.at(3).get<double>(), 4.0 * 2.0 * kPi * 10.0 / 100.0 * 1000.0, 20.0);
  EXPECT_EQ(std::abs(stretch.at(4).get<int>()), 0);
  // Keyframes are told as scans: the skipped scan is none.
  ASSERT_EQ(data.at("loops").at("rows").size(), 2u);
  EXPECT_EQ(data.at("loops").at("rows").at(0).at(0), 81);
  EXPECT_EQ(data.at("loops").at("rows").at(1).at(3), "refused");
}

TEST(HtmlReportTest, ErrorsAndReferenceAreInTheFrameOfTheMap) {
  HandmadeRun run(100);
  run.AddErrors();
  const nlohmann::json data = DataOf(run.Report());
  const nlohmann::json& scans = data.at("scans");
  for (size_t i = 0; i < 100; ++i) {
    EXPECT_NEAR(scans.at("reference_x_mm").at(i).get<double>(), scans.at("x_mm").at(i).get<double>(), 25.0) << i;
    EXPECT_NEAR(scans.at("reference_y_mm").at(i).get<double>(), scans.at("y_mm").at(i).get<double>(), 5.0) << i;
    EXPECT_NEAR(scans.at("error_um").at(i).get<double>(), 20000.0, 2000.0) << i;
  }
  EXPECT_NEAR(data.at("errors").at("ate_rmse_m").get<double>(), 0.02, 0.002);
  EXPECT_EQ(data.at("errors").at("false_loops"), 1);
}

TEST(HtmlReportTest, LoopsThatWereDroppedAgainAreNotAccepted) {
  HandmadeRun run(100);
  run.AddLoop(60, true, "");
  run.AddLoop(72, true, "");
  run.record.finish.refinements.resize(1);
  run.record.finish.refinements[0].dropped_loops.push_back(
      {SubmapId{0}, KeyframeId{72}, SE2(), Eigen::Matrix3d::Identity(), Constraint::Kind::kLoop});
  const nlohmann::json rows = DataOf(run.Report()).at("loops").at("rows");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows.at(0).at(3), "accepted");
  EXPECT_EQ(rows.at(1).at(3), "dropped");
}

TEST(HtmlReportTest, ShowsRollPitchAndHeightWhereThereAreAny) {
  HandmadeRun run(50);
  for (StampedPose3& pose : run.trajectory.poses) {
    pose.position.z() = 0.25;
    pose.orientation = pose.orientation * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitX());
  }
  const nlohmann::json scans = DataOf(run.Report()).at("scans");
  EXPECT_EQ(scans.at("z_mm").at(7), 250);
  EXPECT_EQ(scans.at("pitch_mrad").at(7), 100);
  EXPECT_EQ(scans.at("roll_mrad").at(7), -200);
  EXPECT_FALSE(scans.contains("reference_z_mm"));
}

// The height of the true path is that of the map, wherever the reference has its zero.
TEST(HtmlReportTest, TheTrueHeightFitsTheMap) {
  HandmadeRun run(50);
  for (size_t i = 0; i < 50; ++i) run.trajectory.poses[i].position.z() = 0.5 + 0.01 * static_cast<double>(i);
  run.AddErrors(-40.0);
  const nlohmann::json scans = DataOf(run.Report()).at("scans");
  for (size_t i = 0; i < 50; ++i) {
    EXPECT_NEAR(scans.at("reference_z_mm").at(i).get<double>(), scans.at("z_mm").at(i).get<double>(), 1.0) << i;
  }
}

TEST(HtmlReportTest, TellsOfMovingThingsAndMissingGround) {
  HandmadeRun run(3);
  EXPECT_FALSE(DataOf(run.Report()).at("scans").contains("moving"));
  run.record.scans[1].num_moving = 12;
  run.record.scans[2].has_ground = false;
  run.record.scans[2].searched_wide = true;
  const nlohmann::json scans = DataOf(run.Report()).at("scans");
  EXPECT_EQ(scans.at("moving"), nlohmann::json({0, 12, 0}));
  EXPECT_EQ(scans.at("flags"), "117");
}

TEST(HtmlReportTest, AsksForNothingElse) {
  HandmadeRun run(20);
  const std::string html = run.Report();
  EXPECT_THAT(html, Not(HasSubstr("http:")));
  EXPECT_THAT(html, Not(HasSubstr("https:")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  EXPECT_EQ(Count(html, "src="), 1u);  // The map.
  EXPECT_THAT(html, HasSubstr("src=\"data:image/png;base64,"));
  EXPECT_THAT(run.Report(false), Not(HasSubstr("src=")));
  for (const char* place : {"@TITLE@", "@STYLE@", "@MAP@", "@DATA@", "@SCRIPT@"}) {
    EXPECT_THAT(html, Not(HasSubstr(place)));
  }
}

TEST(HtmlReportTest, StaysSmall) {
  HandmadeRun run(10000);
  for (size_t i = 100; i < 9000; i += 10) run.Reject(i, MatchVerdict::kPoor);
  for (int i = 12; i < 10000; i += 12) {
    for (int k = 0; k < 4; ++k) run.AddLoop(i, k != 0, k != 0 ? "" : "ambiguous");
  }
  run.AddErrors();
  EXPECT_LT(run.Report().size(), 3u << 20);
  // A map with many a fine detail, larger than the report shows it.
  run.map.width = run.map.height = 6000;
  run.map.occupancy.assign(36000000, 0);
  for (size_t i = 0; i < run.map.occupancy.size(); i += 131) run.map.occupancy[i] = static_cast<uint8_t>(i % 101);
  EXPECT_LT(run.Report().size(), 5u << 20);
  // Of a very long run not every scan is drawn.
  const nlohmann::json data = DataOf(HandmadeRun(100000).Report());
  EXPECT_LE(data.at("scans").at("index").size(), 40000u);
  EXPECT_EQ(data.at("run").at("scans").at("read"), 100000);
}

// ---- What needs one.

// What the browser made of a page.
struct Page {
  std::string dom;
  std::string log;

  // The start tag of the element with this id.
  std::string Tag(const std::string& id) const {
    const size_t at = dom.find(" id=\"" + id + "\"");
    if (at == std::string::npos) return "";
    const size_t begin = dom.rfind('<', at);
    return dom.substr(begin, dom.find('>', at) - begin + 1);
  }
  // Attribute `name` of it, -1 if it has none.
  int Number(const std::string& id, const std::string& name) const {
    const std::string tag = Tag(id);
    const size_t at = tag.find(" " + name + "=\"");
    return at == std::string::npos ? -1 : std::atoi(tag.c_str() + at + name.size() + 3);
  }
  bool IsHidden(const std::string& id) const { return Tag(id).find(" hidden") != std::string::npos; }
};

// A decoded screenshot.
class Picture {
 public:
  explicit Picture(const fs::path& path)
      : surface_(cairo_image_surface_create_from_png(path.c_str()), &cairo_surface_destroy) {
    EXPECT_EQ(cairo_surface_status(surface_.get()), CAIRO_STATUS_SUCCESS) << path;
  }

  int width() const { return cairo_image_surface_get_width(surface_.get()); }
  int height() const { return cairo_image_surface_get_height(surface_.get()); }

  // 0xRRGGBB.
  uint32_t At(int column, int row) const {
    const unsigned char* const data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    return reinterpret_cast<const uint32_t*>(data + static_cast<ptrdiff_t>(row) * stride)[column] & 0xffffffu;
  }

  std::map<uint32_t, int> Colours() const {
    std::map<uint32_t, int> colours;
    for (int row = 0; row < height(); ++row) {
      for (int column = 0; column < width(); ++column) ++colours[At(column, row)];
    }
    return colours;
  }

 private:
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
};

class HtmlReportBrowserTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
      if (std::system((std::string("command -v ") + name + " >/dev/null 2>&1").c_str()) == 0) browser_ = name;
      if (!browser_.empty()) break;
    }
    if (browser_.empty()) GTEST_SKIP() << "no Chromium is here to look at the report; install the package chromium";
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::path(testing::TempDir()) / ("report_test_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  fs::path Path(const std::string& name) const { return folder_ / name; }

  // Runs the browser on `html`.
  void Browse(const std::string& html, const std::string& arguments) const {
    std::ofstream(Path("page.html"), std::ios::binary) << html;
    const std::string command =
        "cd '" + folder_.string() + "' && timeout 120 " + browser_ +
        " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"
        " --disable-component-update --disable-sync --hide-scrollbars --enable-logging=stderr"
        " --virtual-time-budget=10000 --user-data-dir='" +
        Path("profile").string() + "' " + arguments + " 'file://" + Path("page.html").string() +
        "' >dom.html 2>log.txt";
    const int status = std::system(command.c_str());
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << ReadFile(Path("log.txt"));
  }

  Page Open(const std::string& html, const std::string& arguments = "--window-size=1280,1600") const {
    Browse(html, "--dump-dom " + arguments);
    return {ReadFile(Path("dom.html")), ReadFile(Path("log.txt"))};
  }

  // Opens a page that must come through without a fault.
  Page OpenWell(const std::string& html, const std::string& arguments = "--window-size=1280,1600") const {
    Page page = Open(html, arguments);
    EXPECT_THAT(page.log, Not(HasSubstr("CONSOLE")));
    EXPECT_THAT(page.dom, HasSubstr("data-errors=\"0\""));
    EXPECT_THAT(page.dom, HasSubstr("data-report=\"drawn\""));
    EXPECT_TRUE(page.IsHidden("problems"));
    return page;
  }

  Picture Photograph(const std::string& html, const std::string& arguments) const {
    Browse(html, "--screenshot='" + Path("shot.png").string() + "' " + arguments);
    return Picture(Path("shot.png"));
  }

 private:
  std::string browser_;
  fs::path folder_;
};

// The other tests would notice if something went wrong.
TEST_F(HtmlReportBrowserTest, FaultsAreToldOnThePage) {
  std::string html = HandmadeRun(20).Report();
  const size_t at = html.find("\"fate\"");
  ASSERT_NE(at, std::string::npos);
  html.replace(at, 6, "\"gone\"");
  const Page page = Open(html);
  EXPECT_THAT(page.log, HasSubstr("CONSOLE"));
  EXPECT_THAT(page.dom, Not(HasSubstr("data-errors=\"0\"")));
  EXPECT_THAT(page.dom, Not(HasSubstr("data-report=\"drawn\"")));
  EXPECT_FALSE(page.IsHidden("problems"));
  EXPECT_NE(page.Tag("problems"), "");
}

TEST_F(HtmlReportBrowserTest, DrawsARunOfTheProgram) {
  PlanarOrchardOptions options;
  options.seed = 5;
  options.rows = 3;
  options.trees_per_row = 7;
  options.lidar.beams = 449;
  const PlanarOrchard orchard(options);
  NpyArray ranges{{orchard.NumScans(), 449}, {}};
  NpyArray stamps{{orchard.NumScans()}, {}};
  for (size_t i = 0; i < orchard.NumScans(); ++i) {
    const LaserScan scan = orchard.Scan(i);
    const bool is_blind = i == 15 || i == 16;
    for (const float range : scan.ranges) {
      ranges.values.push_back(is_blind ? std::numeric_limits<double>::infinity() : range);
    }
    stamps.values.push_back(scan.stamp);
  }
  WriteNpz(Path("run.npz").string(), {{"scan0", ranges}, {"time", stamps}});
  WriteTum(Path("truth.tum").string(), orchard.GroundTruth());
  const std::string command = "cd '" + Path("").string() +
                              "' && '" ARBORSLAM_PROGRAM_DIR
                              "/arborslam_offline' --input run.npz --ground_truth truth.tum --output out --quiet";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const nlohmann::json summary = nlohmann::json::parse(ReadFile(Path("out/summary.json")));
  const std::string html = ReadFile(Path("out/report.html"));

  const Page page = OpenWell(html);
  const int num_scans = static_cast<int>(orchard.NumScans());
  EXPECT_EQ(page.Number("map", "data-drawn-path"), num_scans);
  EXPECT_EQ(page.Number("map", "data-drawn-odometry"), num_scans);
  EXPECT_EQ(page.Number("map", "data-drawn-truth"), num_scans);
  EXPECT_EQ(page.Number("map", "data-drawn-rejected"), summary.at("scans").at("rejected"));
  EXPECT_THAT(page.Tag("map"), HasSubstr("data-drawn-map=\"yes\""));
  EXPECT_EQ(page.Number("chart-score", "data-drawn-points"), num_scans);
  EXPECT_EQ(page.Number("chart-error", "data-drawn-points"), 2 * num_scans);
  EXPECT_EQ(page.Number("chart-times", "data-drawn-points"), num_scans);
  EXPECT_EQ(page.Number("loops-table", "data-rows"), summary.at("loops").at("tried"));
  EXPECT_EQ(page.Number("unused-table", "data-rows"), summary.at("unused_scans").size());
  EXPECT_GE(page.Number("unused-table", "data-rows"), 2);
  EXPECT_THAT(page.dom, HasSubstr("too few points"));
  EXPECT_THAT(page.dom, HasSubstr("wide_score: 0.1"));
  for (const char* section : {"map", "scans", "errors", "loops", "times", "unused"}) {
    EXPECT_FALSE(page.IsHidden(std::string(section) + "-section")) << section;
  }

  const Picture light = Photograph(html, "--window-size=1280,1600");
  EXPECT_EQ(light.width(), 1280);
  EXPECT_EQ(light.height(), 1600);
  const std::map<uint32_t, int> colours = light.Colours();
  EXPECT_GT(colours.size(), 200u);
  const auto pixels = [&](uint32_t colour) { return colours.count(colour) > 0 ? colours.at(colour) : 0; };
  EXPECT_GT(pixels(0x1f6fd6), 1000);   // The path and the scores.
  EXPECT_GT(pixels(0xdddddd), 10000);  // What the map does not know.
  EXPECT_GT(pixels(0xffffff), 100000);
  EXPECT_EQ(light.At(2, 2), 0xf3f5f6u);
}

TEST_F(HtmlReportBrowserTest, DrawsEveryKindOfScanLightAndDarkLargeAndSmall) {
  HandmadeRun run(400);
  run.Reject(40, MatchVerdict::kPoor);
  run.Reject(41, MatchVerdict::kAmbiguous);
  run.Reject(42, MatchVerdict::kTooFewPoints);
  run.Skip(60, "stamp not after the scan before");
  run.record.scans[70].is_inserted = false;
  run.Degenerate(100, 140);
  run.Degenerate(160, 161);
  run.AddLoop(350, true, "");
  run.AddLoop(360, false, "ambiguous");
  run.AddLoop(370, false, kContradictsOthers);
  for (size_t i = 0; i < run.trajectory.poses.size(); ++i) {
    run.trajectory.poses[i].position.z() = run.odometry.poses[i].position.z() =
        0.5 + 0.1 * std::sin(0.05 * static_cast<double>(i));
  }
  run.AddErrors();
  const std::string html = run.Report();
  for (const char* size : {"--window-size=1280,1000", "--window-size=390,844"}) {
    const Page page = OpenWell(html, size);
    EXPECT_EQ(page.Number("map", "data-drawn-path"), 399);
    EXPECT_EQ(page.Number("map", "data-drawn-rejected"), 3);
    EXPECT_EQ(page.Number("map", "data-drawn-degenerate"), 43);
    EXPECT_EQ(page.Number("map", "data-drawn-accepted"), 1);
    EXPECT_EQ(page.Number("map", "data-drawn-refused"), 1);
    EXPECT_EQ(page.Number("map", "data-drawn-dropped"), 1);
    EXPECT_EQ(page.Number("chart-score", "data-drawn-points"), 400);
    EXPECT_EQ(page.Number("chart-error", "data-drawn-points"), 2 * 399);
    EXPECT_EQ(page.Number("chart-attitude", "data-drawn-points"), 2 * 399);
    EXPECT_EQ(page.Number("chart-height", "data-drawn-points"), 2 * 399);
    EXPECT_EQ(page.Number("chart-points", "data-drawn-points"), 400);
    EXPECT_EQ(page.Number("stretches-table", "data-rows"), 2);
    EXPECT_EQ(page.Number("unused-table", "data-rows"), 4);
  }
  const Picture dark = Photograph(html, "--window-size=1280,1000 --blink-settings=preferredColorScheme=0");
  const std::map<uint32_t, int> colours = dark.Colours();
  EXPECT_EQ(dark.At(2, 2), 0x0e1216u);
  EXPECT_GT(colours.count(0x58a6ff) > 0 ? colours.at(0x58a6ff) : 0, 500);
  EXPECT_EQ(Photograph(html, "--window-size=390,844").width(), 390);
}

TEST_F(HtmlReportBrowserTest, TextIsNeverRun) {
  const std::string evil =
      "a</script><script>document.documentElement.dataset.run='1'</script><!--<script>"
      "<img src=x onerror=\"document.documentElement.dataset.run='1'\">&lt;'\"`${1}@DATA@\\u003c\xe2\x80\xa8\xff";
  HandmadeRun run(30);
  run.Reject(5, MatchVerdict::kPoor);
  run.record.input = evil;
  run.record.notices = {evil};
  run.record.scans[5].reason = evil;
  run.AddLoop(20, false, evil);
  run.config = evil;
  run.gates[0].label = evil;
  const std::string html = run.Report();
  const Page page = OpenWell(html);
  EXPECT_THAT(page.dom, Not(HasSubstr("data-run")));
  // What was typed is what is read: title, subtitle, notes, tables and configuration.
  EXPECT_GE(Count(page.dom, "a&lt;/script&gt;&lt;script&gt;document"), 6u);
  EXPECT_GE(Count(page.dom, "${1}@DATA@"), 6u);
  EXPECT_EQ(page.Number("unused-table", "data-rows"), 1);
  EXPECT_FALSE(page.IsHidden("notices"));
  // The rest of the summary is as robust.
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(run.record), nullptr, false).is_discarded());
}

TEST_F(HtmlReportBrowserTest, PanelsWithNothingToShowAreAbsent) {
  HandmadeRun run(1);
  run.config.clear();
  run.gates.clear();
  const Page page = OpenWell(run.Report(false));
  EXPECT_EQ(page.Number("map", "data-drawn-path"), 1);
  EXPECT_THAT(page.Tag("map"), Not(HasSubstr("data-drawn-map")));
  for (const char* section : {"errors-section", "loops-section", "unused-section", "stretches-section", "config"}) {
    EXPECT_NE(page.Tag(section), "") << section;
    EXPECT_TRUE(page.IsHidden(section)) << section;
  }
  EXPECT_EQ(page.Tag("chart-error"), "");
  EXPECT_EQ(page.Tag("chart-height"), "");
}

TEST_F(HtmlReportBrowserTest, ZoomsSortsAndTellsOfScans) {
  HandmadeRun run(300);
  run.Reject(50, MatchVerdict::kPoor);
  run.Reject(70, MatchVerdict::kAmbiguous);
  run.AddLoop(200, true, "");
  run.AddLoop(212, false, "ambiguous");
  run.AddLoop(224, false, "score");
  run.AddErrors();
  std::string html = run.Report();
  // What a user would do; what came of it goes into attributes of the body.
  const std::string script = R"(<script>
    window.addEventListener("load", () => {
      const byId = (id) => document.getElementById(id);
      const note = (name, value) => document.body.setAttribute("data-" + name, value);
      const press = (id, key) => byId(id).dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
      const pick = (id, value) => { byId(id).value = value; byId(id).dispatchEvent(new Event("change")); };
      const point = (id, type, x, y) => {
        const box = byId(id).getBoundingClientRect();
        byId(id).dispatchEvent(new PointerEvent(type, { pointerId: 1, pointerType: "mouse", button: 0, bubbles: true,
          clientX: box.left + x, clientY: box.top + y }));
      };
      // A made-up pointer cannot be captured.
      Element.prototype.setPointerCapture = () => {};
      const before = byId("map").dataset.scaleBar;
      for (let i = 0; i < 6; ++i) press("map", "+");
      note("zoomed", before + " to " + byId("map").dataset.scaleBar);
      for (let i = 0; i < 12; ++i) press("map", "-");
      press("map", "0");
      note("fitted", String(byId("map").dataset.scaleBar === before));
      for (let i = 0; i < 6; ++i) byId("map").dispatchEvent(new WheelEvent("wheel", { deltaY: -800, cancelable: true }));
      note("wheeled", String(byId("map").dataset.scaleBar !== before));
      press("map", "0");
      point("map", "pointerdown", 200, 200), point("map", "pointermove", 260, 200), point("map", "pointerup", 260, 200);
      byId("layer-odometry").click();
      note("odometry", String(byId("map").dataset.drawnOdometry));
      for (const option of byId("colour-by").options) pick("colour-by", option.value);
      pick("colour-by", "fate");
      note("coloured", byId("map").dataset.drawnPath);
      press("chart-score", "ArrowRight"), press("chart-score", "ArrowRight");
      note("told", byId("live").textContent);
      for (let i = 0; i < 4; ++i) press("chart-score", "+");
      note("part", byId("chart-score").dataset.drawnPoints);
      press("chart-score", "0");
      point("chart-error", "pointerdown", 200, 80), point("chart-error", "pointermove", 400, 80);
      point("chart-error", "pointerup", 400, 80);
      note("selected", byId("chart-times").dataset.drawnPoints);
      pick("x-mode", "time"), pick("x-mode", "distance");
      note("all", byId("chart-times").dataset.drawnPoints);
      point("chart-score", "pointermove", 300, 80);
      note("tip", String(!byId("tip").hidden && byId("tip").textContent.includes("MHD score")));
      const cell = () => byId("loops-table").querySelector("tbody td").textContent;
      const scanHead = byId("loops-table").querySelector("th button");
      scanHead.click();
      const up = cell();
      scanHead.click();
      note("sorted", up + " " + cell());
      pick("loop-filter", "refused");
      note("filtered", byId("loops-table").dataset.rows);
      byId("loops-table").querySelector("a.go").click();
      byId("unused-table").querySelector("a.go").click();
      window.dispatchEvent(new Event("beforeprint"));
      window.dispatchEvent(new Event("afterprint"));
    });
  </script></body>)";
  const size_t end = html.rfind("</body>");
  html.replace(end, 7, script);
  const Page page = OpenWell(html);
  const std::string body = page.dom.substr(page.dom.find("<body"), 2000);
  EXPECT_THAT(body, HasSubstr("data-zoomed=\"5 m to 50 cm\""));
  EXPECT_THAT(body, HasSubstr("data-fitted=\"true\""));
  EXPECT_THAT(body, HasSubstr("data-wheeled=\"true\""));
  EXPECT_THAT(body, HasSubstr("data-odometry=\"undefined\""));
  EXPECT_THAT(body, HasSubstr("data-coloured=\"300\""));
  EXPECT_THAT(body, HasSubstr("data-told=\"Scan 1: verdict accepted"));
  EXPECT_THAT(body, HasSubstr("data-tip=\"true\""));
  EXPECT_THAT(body, HasSubstr("data-all=\"300\""));
  EXPECT_THAT(body, HasSubstr("data-sorted=\"200 224\""));
  EXPECT_THAT(body, HasSubstr("data-filtered=\"2\""));
  const auto number = [&](const std::string& name) {
    const size_t at = body.find(" data-" + name + "=\"");
    return at == std::string::npos ? -1 : std::atoi(body.c_str() + at + name.size() + 8);
  };
  EXPECT_GT(number("part"), 40);
  EXPECT_LT(number("part"), 100);
  EXPECT_GT(number("selected"), 30);
  EXPECT_LT(number("selected"), 100);
}

TEST_F(HtmlReportBrowserTest, DrawsTenThousandScans) {
  HandmadeRun run(10000);
  for (size_t i = 100; i < 9000; i += 10) run.Reject(i, MatchVerdict::kPoor);
  for (int i = 6000; i < 10000; i += 4) run.AddLoop(i, true, "");
  run.AddErrors();
  const Page page = OpenWell(run.Report());
  EXPECT_EQ(page.Number("map", "data-drawn-path"), 10000);
  EXPECT_EQ(page.Number("chart-score", "data-drawn-points"), 10000);
  EXPECT_EQ(page.Number("chart-error", "data-drawn-points"), 20000);
  EXPECT_EQ(page.Number("unused-table", "data-rows"), 890);
  EXPECT_EQ(page.Number("loops-table", "data-rows"), 1000);
}

}  // namespace
}  // namespace arborslam
