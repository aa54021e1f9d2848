#include "backend/store/session_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "backend/slam.h"
#include "backend/store/compression.h"
#include "backend/store/database.h"
#include "backend/store/session_format.h"
#include "core/error.h"
#include "core/io/binary_archive.h"

namespace arborslam {
namespace {

constexpr int64_t kMostIds = std::numeric_limits<int>::max();
// [m], [rad] and [s]: what is greater, or no number, was never measured.
constexpr double kGreatestLength = 1e6;
constexpr double kGreatestAngle = 1e3;
constexpr double kGreatestTime = 1e12;

bool IsLength(double value) { return std::abs(value) <= kGreatestLength; }
bool IsAngle(double value) { return std::abs(value) <= kGreatestAngle; }
bool IsTime(double value) { return std::abs(value) <= kGreatestTime; }

bool IsPose(const SE2& pose) { return IsLength(pose.x()) && IsLength(pose.y()) && IsAngle(pose.theta()); }
bool AreFinite(const std::vector<GroundSample>& ground) {
  return std::all_of(ground.begin(), ground.end(), [](const GroundSample& sample) {
    return sample.position.allFinite() && std::isfinite(sample.weight);
  });
}
bool AreFinite(const std::vector<UprightLine>& lines) {
  return std::all_of(lines.begin(), lines.end(), [](const UprightLine& line) {
    return line.direction.allFinite() && std::isfinite(line.range) && std::isfinite(line.slope) &&
           std::isfinite(line.spread);
  });
}
bool IsTilt(const Tilt3& tilt) { return IsAngle(tilt.roll) && IsAngle(tilt.pitch) && IsLength(tilt.z); }

template <int kSize>
bool IsPoint(const Eigen::Matrix<float, kSize, 1>& point) {
  return (point.array().abs() <= static_cast<float>(kGreatestLength)).all();
}

bool ArePoints(const std::vector<Eigen::Vector2f>& points) {
  return std::all_of(points.begin(), points.end(), [](const Eigen::Vector2f& point) { return IsPoint(point); });
}

// A session to read: a file of the present format, or a copy in memory of one of an older format.
std::unique_ptr<Database> OpenSession(const std::string& path) {
  auto database = std::make_unique<Database>(path, Database::Mode::kRead);
  if (SessionFormatOf(database.get()) == kSessionFormat) return database;
  auto copy = std::make_unique<Database>(path, Database::Mode::kMemory);
  copy->CopyFrom(*database);
  MigrateSession(copy.get());
  return copy;
}

// Reads one session, and makes sure of all that others take for granted.
class Reader {
 public:
  Reader(Database* database, SessionStage stage, std::shared_ptr<ValueStore> store = nullptr)
      : database_(*database), stage_(stage), store_(std::move(store)) {}

  SessionContents Read() {
    SessionContents contents;
    contents.config = TextOf(kSessionConfig);
    contents.is_finished = stage_ == SessionStage::kFinished;
    ReadRecordings(&contents);
    ReadScans(&contents);
    ReadKeyframes(&contents);
    ReadPoses(&contents);
    ReadConstraints(&contents);
    ReadSubmaps(&contents);
    if (contents.is_finished) {
      ReadTilts(&contents);
      ShiftAllStamps(&contents);
    } else {
      ReadState(&contents);
    }
    return contents;
  }

  std::string TextOf(const char* key) {
    Database::Statement statement(&database_, "SELECT value FROM session WHERE key = ?");
    statement.BindText(key);
    Require(statement.Step(), std::string("table session, ") + key, "there is none");
    return statement.Text(0);
  }

  bool IsFinished() {
    const std::optional<int64_t> value =
        database_.Integer(std::string("SELECT value FROM session WHERE key = '") + kSessionFinished + "'");
    Require(value == 0 || value == 1, std::string("table session, ") + kSessionFinished, "it is neither 0 nor 1");
    return value == 1;
  }

  std::vector<std::string> RecordingNames() {
    Database::Statement row(&database_, "SELECT id, name FROM recordings ORDER BY id");
    std::vector<std::string> names;
    while (row.Step()) {
      Require(row.Integer(0) == static_cast<int64_t>(names.size()), Part("recording", names.size()), "it is missing");
      names.push_back(row.Text(1));
    }
    Require(!names.empty(), "table recordings", "it is empty");
    return names;
  }

 private:
  // Throws unless `condition` holds of `part`.
  void Require(bool condition, const std::string& part, const std::string& problem) const {
    if (condition) return;
    throw UserError(database_.path() + ", " + part, "is damaged: " + problem, "use a copy, or map the recording again");
  }

  std::string Place(const std::string& part) const { return database_.path() + ", " + part; }

  static std::string Part(const char* what, size_t number) { return what + (" " + std::to_string(number)); }

  void ReadRecordings(SessionContents* contents) {
    for (std::string& name : RecordingNames()) contents->recordings.push_back({std::move(name), 0, 0});
    if (contents->is_finished || contents->recordings.size() == 1) return;
    throw UserError(
        database_.path(),
        "was merged from " + std::to_string(contents->recordings.size()) + " recordings, and no run goes on",
        "map a further recording by itself and merge it with arborslam_session");
  }

  void ReadScans(SessionContents* contents) {
    Database::Statement row(&database_,
                            "SELECT id, stamp, status, data, fingerprint, recording FROM scans ORDER BY id");
    size_t last_recording = 0;
    while (row.Step()) {
      const size_t index = contents->read.size();
      const std::string part = Part("scan", index);
      Require(row.Integer(0) == static_cast<int64_t>(index), part, "it is missing");
      Require(row.Integer(5) >= static_cast<int64_t>(last_recording) &&
                  row.Integer(5) < static_cast<int64_t>(contents->recordings.size()),
              part, "it is of another recording");
      last_recording = static_cast<size_t>(row.Integer(5));
      SessionContents::Recording& recording = contents->recordings[last_recording];
      const std::string bytes = Decompress(row.Bytes(3), Place(part));
      BinaryReader fields(bytes, Place(part));
      SessionContents::ReadScan scan;
      scan.fingerprint = static_cast<uint64_t>(row.Integer(4));
      ScanResult& result = scan.result;
      fields(result);
      Require(result.status == ScanStatus::kMatched || result.status == ScanStatus::kPredicted ||
                  result.status == ScanStatus::kSkipped,
              part, "its status is unknown");
      Require(result.match.verdict >= MatchVerdict::kAccepted && result.match.verdict <= MatchVerdict::kDegenerate,
              part, "its verdict is unknown");
      Require(row.Real(1) == result.stamp && row.Integer(2) == static_cast<int64_t>(result.status), part,
              "its columns contradict each other");
      if (result.status != ScanStatus::kSkipped) {
        PosedScan posed;
        fields(posed);
        Require(IsPose(result.T_odom_base) && IsTilt(result.tilt) && IsPose(posed.T_keyframe_scan) &&
                    IsTilt(posed.tilt) && IsTilt(posed.local_tilt) && IsTilt(posed.odometry_tilt),
                part, "its pose is impossible");
        Require(IsTime(posed.stamp) && (recording.num_posed == 0 || posed.stamp > contents->scans.back().stamp), part,
                "its stamp is not after the one before");
        Require(AreFinite(*posed.ground.Get()) && AreFinite(*posed.lines.Get()), part,
                "its ground or its vertical structures are not finite");
        posed.ground = Kept(posed.ground);
        posed.lines = Kept(posed.lines);
        ++recording.num_posed;
        contents->scans.push_back(std::move(posed));
      }
      fields.CheckEnd();
      contents->read.push_back(std::move(scan));
      ++recording.num_read;
    }
  }

  // In the care of the store, unless there is nothing to take care of.
  template <class T>
  Stored<std::vector<T>> Kept(const Stored<std::vector<T>>& values) const {
    return values.Get()->empty() ? Stored<std::vector<T>>() : values.MovedTo(store_);
  }

  void ReadKeyframes(SessionContents* contents) {
    Database::Statement row(&database_, "SELECT id, is_inserted, scan FROM keyframes ORDER BY id");
    while (row.Step()) {
      const size_t index = contents->keyframes.size();
      const std::string part = Part("keyframe", index);
      Require(row.Integer(0) == static_cast<int64_t>(index), part, "it is missing");
      Keyframe keyframe;
      keyframe.id = KeyframeId{static_cast<int>(index)};
      keyframe.is_inserted = row.Integer(1) != 0;
      const std::string bytes = Decompress(row.Bytes(2), Place(part));
      BinaryReader fields(bytes, Place(part));
      PlanarScan scan;
      fields(scan);
      fields.CheckEnd();
      Require(IsTime(scan.stamp) && ArePoints(scan.points) && ArePoints(scan.free_ends), part,
              "it holds values that are impossible");
      keyframe.scan = {std::move(scan), store_};
      contents->keyframes.push_back(std::move(keyframe));
    }
    for (const PosedScan& scan : contents->scans) {
      Require(scan.keyframe.value >= 0 && static_cast<size_t>(scan.keyframe.value) < contents->keyframes.size(),
              Part("the scan at", static_cast<size_t>(std::max(0.0, scan.stamp))), "its keyframe is missing");
    }
  }

  SE2 PoseOf(const Database::Statement& row, int column, const std::string& part) const {
    const double x = row.Real(column);
    const double y = row.Real(column + 1);
    const double theta = row.Real(column + 2);
    Require(IsLength(x) && IsLength(y) && IsAngle(theta), part, "its pose is impossible");
    return SE2(x, y, theta);
  }

  NodeId NodeOf(const Database::Statement& row, int column, const std::string& part) const {
    const int64_t kind = row.Integer(column);
    const int64_t id = row.Integer(column + 1);
    Require((kind == 0 || kind == 1) && id >= 0 && id <= kMostIds, part, "it names no keyframe or submap");
    if (kind == 0) return KeyframeId{static_cast<int>(id)};
    return SubmapId{static_cast<int>(id)};
  }

  void ReadPoses(SessionContents* contents) {
    Database::Statement row(&database_, "SELECT kind, id, x, y, theta FROM poses WHERE stage = ? ORDER BY kind, id");
    row.Bind(static_cast<int64_t>(stage_));
    size_t num_keyframes = 0;
    size_t num_submaps = 0;
    while (row.Step()) {
      const NodeId id = NodeOf(row, 0, "table poses");
      size_t& expected = id.kind == NodeId::Kind::kKeyframe ? num_keyframes : num_submaps;
      const std::string part =
          Part(id.kind == NodeId::Kind::kKeyframe ? "pose of keyframe" : "pose of submap", expected);
      Require(static_cast<size_t>(id.value) == expected, part, "it is missing");
      ++expected;
      contents->graph.AddNode(id, PoseOf(row, 2, part));
    }
    Require(num_keyframes == contents->keyframes.size(), "table poses", "it does not go with the keyframes");
  }

  void ReadConstraints(SessionContents* contents) {
    Database::Statement row(&database_,
                            "SELECT id, provenance, from_kind, from_id, to_kind, to_id, x, y, theta, i_xx, i_xy, i_xt, "
                            "i_yx, i_yy, i_yt, i_tx, i_ty, i_tt FROM constraints WHERE stage = ? ORDER BY id");
    row.Bind(static_cast<int64_t>(stage_));
    while (row.Step()) {
      const size_t index = contents->graph.constraints().size();
      const std::string part = Part("constraint", index);
      Require(row.Integer(0) == static_cast<int64_t>(index), part, "it is missing");
      Constraint constraint;
      const std::optional<Constraint::Kind> kind = ConstraintKindOf(row.Text(1));
      Require(kind.has_value(), part, "its provenance is unknown");
      constraint.kind = *kind;
      constraint.from = NodeOf(row, 2, part);
      constraint.to = NodeOf(row, 4, part);
      constraint.T_from_to = PoseOf(row, 6, part);
      for (int i = 0; i < 9; ++i) constraint.information(i / 3, i % 3) = row.Real(9 + i);
      const auto exists = [contents](NodeId id) { return contents->graph.poses().count(id) > 0; };
      Require(exists(constraint.from) && exists(constraint.to) && !(constraint.from == constraint.to), part,
              "it is between keyframes or submaps that do not exist");
      Require(constraint.information.allFinite(), part, "its information is not finite");
      contents->graph.AddConstraint(constraint);
    }
  }

  void ReadSubmaps(SessionContents* contents) {
    Database::Statement row(&database_, "SELECT id, data FROM submaps WHERE stage = ? ORDER BY id");
    row.Bind(static_cast<int64_t>(stage_));
    while (row.Step()) {
      const int64_t id = row.Integer(0);
      const std::string part = Part("submap", contents->submaps.size());
      const std::string bytes = Decompress(row.Bytes(1), Place(part));
      BinaryReader fields(bytes, Place(part));
      Submap submap;
      fields(submap);
      fields.CheckEnd();
      Require(submap.id.value == id && contents->graph.poses().count(submap.id) > 0, part, "it has no pose");
      for (const KeyframeId keyframe : submap.keyframes) {
        Require(keyframe.value >= 0 && static_cast<size_t>(keyframe.value) < contents->keyframes.size(), part,
                "a keyframe of it is missing");
      }
      const std::shared_ptr<const std::vector<OccupiedCell>> cells = submap.cells.Get();
      for (const OccupiedCell& cell : *cells) {
        Require(IsPoint(cell.centroid) && std::isfinite(cell.log_odds), part, "a cell of it is impossible");
      }
      submap.cells = Kept(submap.cells);
      contents->submaps.push_back(std::move(submap));
    }
  }

  void ReadTilts(SessionContents* contents) {
    Database::Statement row(&database_, "SELECT scan, roll, pitch, z FROM tilts ORDER BY scan");
    size_t index = 0;
    for (; row.Step(); ++index) {
      const std::string part = Part("tilt of scan", index);
      Require(row.Integer(0) == static_cast<int64_t>(index) && index < contents->scans.size(), part, "it is misplaced");
      contents->scans[index].tilt = {row.Real(1), row.Real(2), row.Real(3)};
      Require(IsTilt(contents->scans[index].tilt), part, "it is impossible");
    }
    Require(index == contents->scans.size(), "table tilts", "it does not go with the scans");
  }

  void ShiftAllStamps(SessionContents* contents) {
    Database::Statement row(&database_, "SELECT value FROM session WHERE key = ?");
    row.BindText(kSessionStampShift);
    const std::string part = std::string("table session, ") + kSessionStampShift;
    Require(row.Step(), part, "there is none");
    const double shift = row.Real(0);
    Require(IsTime(shift), part, "it is impossible");
    for (PosedScan& scan : contents->scans) scan.stamp += shift;
    ShiftStamps(shift, &contents->keyframes);
  }

  void ReadState(SessionContents* contents) {
    Database::Statement row(&database_, "SELECT data FROM state");
    if (!row.Step()) {
      Require(contents->read.empty(), "table state", "it is empty");
      return;
    }
    const std::string bytes = Decompress(row.Bytes(0), Place("table state"));
    BinaryReader fields(bytes, Place("table state"));
    fields(contents->state);
    fields.CheckEnd();
  }

  Database& database_;
  SessionStage stage_;
  std::shared_ptr<ValueStore> store_;
};

SessionContents ReadStage(const std::string& path, std::optional<SessionStage> stage,
                          const std::shared_ptr<ValueStore>& store) {
  const std::unique_ptr<Database> database = OpenSession(path);
  const bool is_finished = Reader(database.get(), SessionStage::kTracked).IsFinished();
  return Reader(database.get(), stage.value_or(is_finished ? SessionStage::kFinished : SessionStage::kTracked), store)
      .Read();
}

}  // namespace

SessionContents ReadSession(const std::string& path, const std::shared_ptr<ValueStore>& store) {
  return ReadStage(path, std::nullopt, store);
}

SessionContents ReadTracked(const std::string& path, const std::shared_ptr<ValueStore>& store) {
  return ReadStage(path, SessionStage::kTracked, store);
}

SessionSummary ReadSessionSummary(const std::string& path) {
  SessionSummary summary;
  {
    Database file(path, Database::Mode::kRead);
    summary.format = SessionFormatOf(&file);
  }
  const std::unique_ptr<Database> database = OpenSession(path);
  Reader reader(database.get(), SessionStage::kTracked);
  summary.recordings = reader.RecordingNames();
  summary.config = reader.TextOf(kSessionConfig);
  summary.is_finished = reader.IsFinished();
  return summary;
}

SessionContents Completed(SessionContents contents, const SlamOptions& options, const std::string& place) {
  if (contents.is_finished) return contents;
  SessionContents completed;
  completed.recordings = contents.recordings;
  completed.config = contents.config;
  completed.read = contents.read;
  Slam slam(options, 1, std::move(contents), place);
  slam.Finish(true);
  completed.scans = slam.scans();
  completed.keyframes = slam.keyframes();
  completed.submaps = slam.submaps();
  completed.graph = slam.graph();
  return completed;
}

std::vector<std::string> DatabaseProblems(const std::string& path) {
  Database database(path, Database::Mode::kRead);
  Database::Statement row(&database, "PRAGMA integrity_check(10)");
  std::vector<std::string> problems;
  while (row.Step()) {
    if (row.Text(0) != "ok") problems.push_back(row.Text(0));
  }
  return problems;
}

int MigrateSessionFile(const std::string& path) {
  Database database(path, Database::Mode::kWrite);
  const int format = SessionFormatOf(&database);
  MigrateSession(&database);
  return format;
}

}  // namespace arborslam
