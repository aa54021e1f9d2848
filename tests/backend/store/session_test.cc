// Sessions: what is written comes back, and a run goes on from them.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "backend/slam.h"
#include "backend/store/fingerprint.h"
#include "backend/store/session_format.h"
#include "backend/store/session_reader.h"
#include "backend/store/session_writer.h"
#include "core/error.h"
#include "core/io/binary_archive.h"
#include "core/simulation/orchard.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"
#include "core/simulation/simulated_run.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

std::vector<Scan> PlanarScans() {
  PlanarOrchardOptions options;
  options.seed = 5;
  options.rows = 3;
  options.trees_per_row = 7;
  options.lidar.beams = 449;
  const PlanarOrchard orchard(options);
  std::vector<Scan> scans;
  for (size_t i = 0; i < orchard.NumScans(); ++i) scans.emplace_back(orchard.Scan(i));
  // One that cannot be used, and one that comes too late.
  LaserScan empty = orchard.Scan(0);
  for (float& range : empty.ranges) range = std::numeric_limits<float>::infinity();
  empty.stamp -= 1.0;
  scans.insert(scans.begin(), empty);
  scans.insert(scans.begin() + 20, scans[10]);
  return scans;
}

// Sweeps that do not tell how long they last.
std::vector<Scan> SpatialScans(size_t num_sweeps) {
  OrchardOptions options;
  options.run.seed = 5;
  const SimulatedRun run(options.run, MakeOrchard(options));
  std::vector<Scan> scans;
  for (size_t i = 0; i < num_sweeps; ++i) {
    LidarSweep sweep = run.Sweep(i);
    sweep.times.clear();
    sweep.is_duration_guessed = true;
    scans.emplace_back(std::move(sweep));
  }
  return scans;
}

std::string ErrorOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

template <class Value>
std::string BytesOf(const Value& value) {
  BinaryWriter writer;
  writer(value);
  return writer.bytes();
}

void ExpectSameGraph(const PoseGraph& a, const PoseGraph& b) {
  EXPECT_EQ(BytesOf(a.poses()), BytesOf(b.poses()));
  EXPECT_EQ(BytesOf(a.constraints()), BytesOf(b.constraints()));
}

void ExpectSameKeyframes(const std::vector<Keyframe>& a, const std::vector<Keyframe>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].is_inserted, b[i].is_inserted);
    EXPECT_EQ(BytesOf(a[i].scan), BytesOf(b[i].scan)) << i;
  }
}

// A run of `scans` in one piece.
Slam WholeRun(const std::vector<Scan>& scans, std::shared_ptr<ValueStore> store = nullptr) {
  Slam slam(SlamOptions(), 1, std::move(store));
  for (const Scan& scan : scans) std::visit([&slam](const auto& any) { slam.AddScan(any); }, scan);
  slam.Finish(false);
  return slam;
}

class SessionTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("session_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name = "session.db") const { return (folder_ / name).string(); }

  static ScanResult Add(const Scan& scan, Slam* slam, SessionWriter* session) {
    const ScanResult result = std::visit([slam](const auto& any) { return slam->AddScan(any); }, scan);
    session->Add(FingerprintOf(scan), result, *slam);
    return result;
  }

  // Tracks `scans` up to `end`, and leaves the session as it is then.
  std::vector<ScanResult> TrackUpTo(size_t end, const std::vector<Scan>& scans, Slam* slam) const {
    const auto session = SessionWriter::Create(Path(), "window:\n  num_keyframes: 15\n", "a recording");
    std::vector<ScanResult> results;
    for (size_t i = 0; i < end; ++i) results.push_back(Add(scans[i], slam, session.get()));
    session->Commit(*slam);
    return results;
  }

  // A run of `scans` that is broken off after `end` of them, and gone on with.
  Slam GoOnAfter(size_t end, const std::vector<Scan>& scans) const {
    Slam slam(SlamOptions(), 1);
    TrackUpTo(end, scans, &slam);
    return GoOn(scans);
  }

  // Goes on with the session and ends the run; returns the run.
  Slam GoOn(const std::vector<Scan>& scans, const std::shared_ptr<ValueStore>& store = nullptr) const {
    SessionContents contents = ReadTracked(Path(), store);
    const auto session = SessionWriter::Continue(Path(), contents);
    const size_t begin = contents.read.size();
    for (size_t i = 0; i < begin; ++i) EXPECT_EQ(contents.read[i].fingerprint, FingerprintOf(scans[i]));
    Slam slam(SlamOptions(), 1, std::move(contents), Path(), store);
    for (size_t i = begin; i < scans.size(); ++i) Add(scans[i], &slam, session.get());
    session->Commit(slam);
    const FinishResult finish = slam.Finish(false);
    session->Finish(slam, finish.sweep_duration ? finish.sweep_duration->stamp_shift : 0.0);
    return slam;
  }

 private:
  fs::path folder_;
};

TEST_F(SessionTest, HoldsAllOfARunThatHasNotEnded) {
  const std::vector<Scan> scans = PlanarScans();
  SlamOptions options;
  options.tracker.submap_length = 12.0;
  Slam slam(options, 1);
  const std::vector<ScanResult> results = TrackUpTo(scans.size(), scans, &slam);
  ASSERT_FALSE(slam.submaps().empty());
  const SessionContents contents = ReadSession(Path());
  EXPECT_FALSE(contents.is_finished);
  EXPECT_EQ(contents.config, "window:\n  num_keyframes: 15\n");
  ASSERT_EQ(contents.read.size(), scans.size());
  for (size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(contents.read[i].fingerprint, FingerprintOf(scans[i]));
    EXPECT_EQ(BytesOf(contents.read[i].result), BytesOf(results[i])) << i;
  }
  EXPECT_EQ(contents.read[0].result.status, ScanStatus::kSkipped);
  EXPECT_EQ(BytesOf(contents.scans), BytesOf(slam.scans()));
  ExpectSameKeyframes(contents.keyframes, slam.keyframes());
  EXPECT_EQ(BytesOf(contents.submaps), BytesOf(slam.submaps()));
  ExpectSameGraph(contents.graph, slam.graph());
  EXPECT_EQ(contents.state, slam.SaveState());
  EXPECT_TRUE(DatabaseProblems(Path()).empty());
  const SessionSummary summary = ReadSessionSummary(Path());
  EXPECT_EQ(summary.format, kSessionFormat);
  EXPECT_EQ(summary.recordings, std::vector<std::string>{"a recording"});
  EXPECT_FALSE(summary.is_finished);

  // What has not been finished is completed on demand.
  const SessionContents completed = Completed(contents, options, Path());
  slam.Finish(true);
  EXPECT_EQ(BytesOf(completed.submaps), BytesOf(slam.submaps()));
  EXPECT_GT(completed.submaps.size(), contents.submaps.size());
}

TEST_F(SessionTest, ComesToTheSameBitsWhateverIsKeptInMemory) {
  for (const auto& scans : {PlanarScans(), SpatialScans(60)}) {
    const Slam whole = WholeRun(scans);
    const auto store = std::make_shared<ValueStore>(testing::TempDir(), 20000);
    const auto expect_same = [&](const Slam& slam) {
      ExpectSameGraph(slam.graph(), whole.graph());
      EXPECT_EQ(BytesOf(slam.scans()), BytesOf(whole.scans()));
      EXPECT_EQ(BytesOf(slam.submaps()), BytesOf(whole.submaps()));
      ExpectSameKeyframes(slam.keyframes(), whole.keyframes());
      EXPECT_LE(store->bytes_in_memory(), 20000u);
    };
    expect_same(WholeRun(scans, store));
    EXPECT_GT(store->bytes_in_file(), 40000u);
    {
      Slam tracked(SlamOptions(), 1, store);
      TrackUpTo(scans.size() / 2, scans, &tracked);
    }
    expect_same(GoOn(scans, store));
    const SessionContents contents = ReadSession(Path(), store);
    EXPECT_EQ(BytesOf(contents.scans), BytesOf(whole.scans()));
    EXPECT_EQ(BytesOf(contents.submaps), BytesOf(whole.submaps()));
    ExpectSameKeyframes(contents.keyframes, whole.keyframes());
  }
}

TEST_F(SessionTest, GoesOnToTheSameBitsFromAnyScan) {
  const std::vector<Scan> scans = PlanarScans();
  const Slam whole = WholeRun(scans);
  for (const size_t end : {size_t{2}, size_t{3}, size_t{9}, size_t{21}, scans.size() / 2, scans.size()}) {
    SCOPED_TRACE(end);
    const Slam resumed = GoOnAfter(end, scans);
    ExpectSameGraph(resumed.graph(), whole.graph());
    EXPECT_EQ(BytesOf(resumed.scans()), BytesOf(whole.scans()));
    EXPECT_EQ(BytesOf(resumed.submaps()), BytesOf(whole.submaps()));
    // And the session holds what came of it.
    const SessionContents contents = ReadSession(Path());
    EXPECT_TRUE(contents.is_finished);
    ExpectSameGraph(contents.graph, whole.graph());
    EXPECT_EQ(BytesOf(contents.scans), BytesOf(whole.scans()));
    EXPECT_EQ(BytesOf(contents.submaps), BytesOf(whole.submaps()));
  }
}

TEST_F(SessionTest, GoesOnWithWheelOdometry) {
  std::vector<Scan> scans = PlanarScans();
  SE2 wheels(1.0, 2.0, 3.0);
  for (size_t i = 0; i < scans.size(); ++i) {
    // Some scans have none.
    if (i % 11 != 5) std::get<LaserScan>(scans[i]).odometry = wheels;
    wheels = wheels * SE2(0.27, 0.01, 0.02);
  }
  const Slam whole = WholeRun(scans);
  for (const size_t end : {size_t{2}, size_t{6}, size_t{13}, scans.size() / 2}) {
    SCOPED_TRACE(end);
    const Slam resumed = GoOnAfter(end, scans);
    ExpectSameGraph(resumed.graph(), whole.graph());
    EXPECT_EQ(BytesOf(resumed.scans()), BytesOf(whole.scans()));
  }
}

TEST_F(SessionTest, GoesOnWithSweepsToo) {
  const std::vector<Scan> scans = SpatialScans(90);
  const Slam whole = WholeRun(scans);
  for (const size_t end : {size_t{1}, size_t{45}}) {
    SCOPED_TRACE(end);
    const Slam resumed = GoOnAfter(end, scans);
    ExpectSameGraph(resumed.graph(), whole.graph());
    EXPECT_EQ(BytesOf(resumed.scans()), BytesOf(whole.scans()));
    const SessionContents contents = ReadSession(Path());
    EXPECT_EQ(BytesOf(contents.scans), BytesOf(whole.scans()));
    ExpectSameKeyframes(contents.keyframes, whole.keyframes());
  }
}

TEST_F(SessionTest, AFinishedSessionGoesOnAsWell) {
  const std::vector<Scan> scans = PlanarScans();
  const Slam whole = WholeRun(scans);
  const std::vector<Scan> half(scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(scans.size() / 2));
  Slam slam(SlamOptions(), 1);
  TrackUpTo(10, half, &slam);
  GoOn(half);
  EXPECT_TRUE(ReadSession(Path()).is_finished);
  EXPECT_FALSE(fs::exists(Path() + "-wal"));
  ExpectSameGraph(GoOn(scans).graph(), whole.graph());
}

TEST_F(SessionTest, LosesWhatWasNotCommittedAndNothingElse) {
  const std::vector<Scan> scans = PlanarScans();
  Slam slam(SlamOptions(), 1);
  std::string before;
  {
    const auto session = SessionWriter::Create(Path(), "", "");
    for (size_t i = 0; i < 10; ++i) Add(scans[i], &slam, session.get());
    session->Commit(slam);
    before = BytesOf(slam.graph().poses());
    Add(scans[10], &slam, session.get());
  }
  const SessionContents contents = ReadSession(Path());
  EXPECT_EQ(contents.read.size(), 10u);
  EXPECT_EQ(BytesOf(contents.graph.poses()), before);
}

std::string BytesOfFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// No temporary files stay.
size_t NumFilesBeside(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_F(SessionTest, TakesItsPlaceWithTheFirstKeyframe) {
  const std::vector<Scan> scans = PlanarScans();
  std::ofstream(Path()) << "an earlier result";
  for (const bool is_discarded : {false, true}) {
    Slam slam(SlamOptions(), 1);
    const auto session = SessionWriter::Create(Path(), "", "");
    Add(scans[0], &slam, session.get());
    session->Commit(slam);
    ASSERT_TRUE(slam.keyframes().empty());
    EXPECT_EQ(BytesOfFile(Path()), "an earlier result");
    if (is_discarded) session->Discard();
  }
  EXPECT_EQ(BytesOfFile(Path()), "an earlier result");
  EXPECT_EQ(NumFilesBeside(Path()), 1u);

  Slam slam(SlamOptions(), 1);
  const auto session = SessionWriter::Create(Path(), "", "a recording");
  Add(scans[0], &slam, session.get());
  Add(scans[1], &slam, session.get());
  // As after the end of a killed program: what a copy of the files holds.
  fs::create_directories(Path("copy"));
  for (const char* ending : {"", "-wal"}) {
    if (fs::exists(Path() + ending)) fs::copy_file(Path() + ending, Path("copy/session.db") + ending);
  }
  EXPECT_EQ(ReadSession(Path("copy/session.db")).read.size(), 2u);
  Add(scans[2], &slam, session.get());
  session->Commit(slam);
  slam.Finish(true);
  session->Finish(slam, 0.0);
  EXPECT_EQ(ReadSession(Path()).read.size(), 3u);
  EXPECT_EQ(NumFilesBeside(Path()), 2u);
  // One that took its place can still be taken away.
  Slam another(SlamOptions(), 1);
  const auto discarded = SessionWriter::Create(Path(), "", "");
  Add(scans[1], &another, discarded.get());
  discarded->Discard();
  EXPECT_EQ(NumFilesBeside(Path()), 1u);
}

TEST_F(SessionTest, GoesOnWithACopyAndLeavesTheSource) {
  const std::vector<Scan> scans = PlanarScans();
  Slam slam(SlamOptions(), 1);
  TrackUpTo(10, scans, &slam);
  const std::string before = BytesOfFile(Path());
  std::ofstream(Path("copy.db")) << "an earlier result";
  SessionContents contents = ReadTracked(Path());
  {
    const auto session = SessionWriter::ContinueCopy(Path(), Path("copy.db"), contents);
    EXPECT_EQ(BytesOfFile(Path("copy.db")), "an earlier result");
    Slam resumed(SlamOptions(), 1, contents, Path());
    Add(scans[10], &resumed, session.get());
    session->Commit(resumed);
  }
  EXPECT_EQ(ReadSession(Path("copy.db")).read.size(), 11u);
  EXPECT_TRUE(BytesOfFile(Path()) == before);
  // What is gone on with in its place is never thrown away.
  SessionWriter::Continue(Path(), contents)->Discard();
  EXPECT_EQ(ReadSession(Path()).read.size(), 10u);
  MoveSession(Path("copy.db"), Path());
  EXPECT_EQ(ReadSession(Path()).read.size(), 11u);
  EXPECT_FALSE(fs::exists(Path("copy.db")));
  EXPECT_NE(ErrorOf([this] { MoveSession(Path("copy.db"), Path()); }).find("cannot be created"), std::string::npos);
  EXPECT_EQ(ReadSession(Path()).read.size(), 11u);
}

TEST_F(SessionTest, ReadsAndMigratesTheFirstFormat) {
  const std::vector<Scan> scans = PlanarScans();
  Slam slam(SlamOptions(), 1);
  TrackUpTo(30, scans, &slam);
  {
    // As format 1 had it.
    Database database(Path(), Database::Mode::kWrite);
    database.Execute(
        "INSERT INTO session SELECT 'input', name FROM recordings; DROP TABLE recordings;"
        "ALTER TABLE scans DROP COLUMN recording; ALTER TABLE scans DROP COLUMN fingerprint; PRAGMA user_version = 1");
  }
  EXPECT_EQ(ReadSessionSummary(Path()).format, 1);
  const SessionContents old = ReadSession(Path());
  ExpectSameGraph(old.graph, slam.graph());
  ASSERT_EQ(old.read.size(), 30u);
  ASSERT_EQ(old.recordings.size(), 1u);
  EXPECT_EQ(old.recordings[0].name, "a recording");
  EXPECT_EQ(old.recordings[0].num_read, 30u);
  EXPECT_EQ(old.read[3].fingerprint, 0u);
  // Reading changed nothing.
  EXPECT_EQ(ReadSessionSummary(Path()).format, 1);
  EXPECT_EQ(MigrateSessionFile(Path()), 1);
  EXPECT_EQ(MigrateSessionFile(Path()), kSessionFormat);
  const SessionContents migrated = ReadSession(Path());
  ExpectSameGraph(migrated.graph, slam.graph());
  ExpectSameKeyframes(migrated.keyframes, slam.keyframes());
  EXPECT_EQ(migrated.state, slam.SaveState());
}

// Two recordings in one session, as merging leaves them; the second one's stamps begin before the first one's end.
SessionContents OfTwoRecordings() {
  const std::vector<Scan> scans = PlanarScans();
  Slam slam(SlamOptions(), 1);
  SessionContents contents;
  for (const Scan& scan : scans) {
    contents.read.push_back({FingerprintOf(scan), slam.AddScan(std::get<LaserScan>(scan))});
  }
  slam.Finish(false);
  contents.config = "window:\n  num_keyframes: 15\n";
  contents.is_finished = true;
  contents.scans = slam.scans();
  contents.keyframes = slam.keyframes();
  contents.submaps = slam.submaps();
  contents.graph = slam.graph();
  contents.recordings = {{"first", 22, 20}, {"second", scans.size() - 22, contents.scans.size() - 20}};
  for (size_t i = 20; i < contents.scans.size(); ++i) contents.scans[i].stamp -= 18.5;
  return contents;
}

TEST_F(SessionTest, AMergedSessionComesBackAndNoRunGoesOnWithIt) {
  const SessionContents contents = OfTwoRecordings();
  ASSERT_EQ(contents.read[20].result.status, ScanStatus::kSkipped);
  WriteSession(Path(), contents);
  const SessionContents read = ReadSession(Path());
  EXPECT_TRUE(read.is_finished);
  EXPECT_EQ(read.config, contents.config);
  ASSERT_EQ(read.recordings.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.recordings[i].name, contents.recordings[i].name);
    EXPECT_EQ(read.recordings[i].num_read, contents.recordings[i].num_read);
    EXPECT_EQ(read.recordings[i].num_posed, contents.recordings[i].num_posed);
  }
  ASSERT_EQ(read.read.size(), contents.read.size());
  for (size_t i = 0; i < read.read.size(); ++i) {
    EXPECT_EQ(read.read[i].fingerprint, contents.read[i].fingerprint);
    EXPECT_EQ(BytesOf(read.read[i].result), BytesOf(contents.read[i].result));
  }
  EXPECT_EQ(BytesOf(read.scans), BytesOf(contents.scans));
  ExpectSameKeyframes(read.keyframes, contents.keyframes);
  EXPECT_EQ(BytesOf(read.submaps), BytesOf(contents.submaps));
  ExpectSameGraph(read.graph, contents.graph);
  EXPECT_EQ(ReadSessionSummary(Path()).recordings, (std::vector<std::string>{"first", "second"}));
  EXPECT_TRUE(DatabaseProblems(Path()).empty());
  const std::string error = ErrorOf([this] { ReadTracked(Path()); });
  EXPECT_NE(error.find("was merged from 2 recordings"), std::string::npos) << error;
  // Of one recording the stamps rise.
  Database(Path(), Database::Mode::kWrite).Execute("UPDATE scans SET recording = 0");
  EXPECT_NE(ErrorOf([this] { ReadSession(Path()); }).find("its stamp is not after"), std::string::npos);
}

TEST_F(SessionTest, RefusesNewerForeignAndMissingFiles) {
  Slam slam(SlamOptions(), 1);
  TrackUpTo(5, PlanarScans(), &slam);
  Database(Path(), Database::Mode::kWrite).Execute("PRAGMA user_version = 5");
  for (const auto& read : {std::function<void()>([this] { ReadSession(Path()); }),
                           std::function<void()>([this] { MigrateSessionFile(Path()); })}) {
    EXPECT_NE(ErrorOf(read).find("is of session format 5, newer than 4"), std::string::npos) << ErrorOf(read);
  }
  Database(Path("other.db"), Database::Mode::kCreate).Execute("CREATE TABLE a (b)");
  EXPECT_NE(ErrorOf([this] { ReadSession(Path("other.db")); }).find("is an SQLite database but not a session"),
            std::string::npos);
  std::ofstream(Path("picture.db"), std::ios::binary) << "\x89PNG\r\n\x1a\n" << std::string(5000, 'x');
  EXPECT_NE(ErrorOf([this] { ReadSession(Path("picture.db")); }).find("is not a session"), std::string::npos);
  EXPECT_NE(ErrorOf([this] { ReadSession(Path("none.db")); }).find("none.db"), std::string::npos);
}

TEST_F(SessionTest, NamesWhatIsMissingInside) {
  Slam slam(SlamOptions(), 1);
  const std::vector<std::pair<std::string, std::string>> damages = {
      {"DELETE FROM scans WHERE id = 4", "scan 4"},
      {"DELETE FROM keyframes WHERE id = 2", "keyframe 2"},
      {"DELETE FROM poses WHERE kind = 0 AND id = 1", "pose of keyframe 1"},
      {"DELETE FROM constraints WHERE id = 0", "constraint 0"},
      {"UPDATE constraints SET provenance = 'magic' WHERE id = 1", "constraint 1"},
      {"UPDATE constraints SET to_id = 999 WHERE id = 1", "constraint 1"},
      {"UPDATE poses SET x = 'far' WHERE kind = 0 AND id = 1", "x holds a value of another type"},
      {"UPDATE poses SET x = 4e35 WHERE kind = 0 AND id = 1", "pose of keyframe 1: is damaged: its pose is impossible"},
      {"UPDATE poses SET theta = -9e999 WHERE kind = 0 AND id = 1", "pose of keyframe 1: is damaged"},
      {"UPDATE constraints SET y = -1e7 WHERE id = 1", "constraint 1: is damaged: its pose is impossible"},
      {"UPDATE constraints SET i_tt = 9e999 WHERE id = 1", "constraint 1: is damaged: its information is not finite"},
      {"UPDATE keyframes SET scan = x'00' WHERE id = 1", "keyframe 1"},
      {"DELETE FROM state", "table state"},
      {"DELETE FROM session WHERE key = 'config'", "config"},
      {"DROP TABLE submaps", "submaps"},
      {"DELETE FROM recordings", "table recordings"},
      {"UPDATE recordings SET id = 1", "recording 0"},
      {"UPDATE scans SET recording = 1 WHERE id = 3", "scan 3"},
  };
  const std::vector<Scan> scans = PlanarScans();
  TrackUpTo(15, scans, &slam);
  fs::copy_file(Path(), Path("whole.db"));
  for (const auto& [damage, part] : damages) {
    fs::copy_file(Path("whole.db"), Path(), fs::copy_options::overwrite_existing);
    Database(Path(), Database::Mode::kWrite).Execute(damage);
    const std::string error = ErrorOf([this] { ReadSession(Path()); });
    EXPECT_NE(error.find(Path()), std::string::npos) << damage << ": " << error;
    EXPECT_NE(error.find(part), std::string::npos) << damage << ": " << error;
  }
  // Tables that are whole but not of one moment.
  fs::copy_file(Path("whole.db"), Path(), fs::copy_options::overwrite_existing);
  Database(Path(), Database::Mode::kWrite)
      .Execute("DELETE FROM constraints WHERE id = (SELECT max(id) FROM constraints)");
  EXPECT_NE(ErrorOf([this] { Slam resumed(SlamOptions(), 1, ReadTracked(Path()), Path()); }).find("not of one moment"),
            std::string::npos);
}

TEST_F(SessionTest, SurvivesDamageAnywhere) {
  Slam slam(SlamOptions(), 1);
  TrackUpTo(25, PlanarScans(), &slam);
  std::ifstream file(Path(), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  Random random(3);
  int num_noticed = 0;
  for (int i = 0; i < 150; ++i) {
    std::string damaged = bytes;
    const auto begin = static_cast<size_t>(random.Uniform(0.0, static_cast<double>(bytes.size())));
    const auto length = static_cast<size_t>(random.Uniform(1.0, 64.0));
    if (i % 10 == 0) {
      damaged.resize(begin);
    } else {
      for (size_t k = begin; k < std::min(begin + length, damaged.size()); ++k) {
        damaged[k] = static_cast<char>(random.Uniform(0.0, 256.0));
      }
    }
    std::ofstream(Path("damaged.db"), std::ios::binary) << damaged;
    const std::string error = ErrorOf([this] {
      Completed(ReadSession(Path("damaged.db")), SlamOptions(), Path("damaged.db"));
      DatabaseProblems(Path("damaged.db"));
    });
    if (error.empty()) continue;
    ++num_noticed;
    EXPECT_NE(error.find("damaged.db"), std::string::npos) << error;
  }
  // The rest hit pages and bytes that say nothing, or made numbers other numbers.
  EXPECT_GT(num_noticed, 50);
}

}  // namespace
}  // namespace arborslam
