// Feeds the reader of sessions with damaged ones, for libFuzzer: whole and unfinished sessions of a short run, in which
// columns of any row are replaced or fields inside of compressed ones are overwritten, cut or added. What the reader
// takes must be written and read back alike, be completed and gone on with; whatever is refused must be a `UserError`.
// Built with -DARBORSLAM_BUILD_FUZZERS=ON and clang.

#include <fuzzer/FuzzedDataProvider.h>
#include <glog/logging.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "backend/slam.h"
#include "backend/store/compression.h"
#include "backend/store/database.h"
#include "backend/store/fingerprint.h"
#include "backend/store/session_reader.h"
#include "backend/store/session_writer.h"
#include "core/error.h"
#include "core/io/binary_archive.h"
#include "core/simulation/planar_orchard.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

// Tables and their keys.
constexpr std::array<std::pair<const char*, const char*>, 9> kTables = {{{"session", "key"},
                                                                         {"recordings", "id"},
                                                                         {"scans", "id"},
                                                                         {"keyframes", "id"},
                                                                         {"poses", "stage, kind, id"},
                                                                         {"constraints", "stage, id"},
                                                                         {"submaps", "stage, id"},
                                                                         {"tilts", "scan"},
                                                                         {"state", "id"}}};

const PlanarOrchard& Orchard() {
  static const PlanarOrchard orchard([] {
    PlanarOrchardOptions options;
    options.rows = 2;
    options.trees_per_row = 4;
    options.lidar.beams = 181;
    return options;
  }());
  return orchard;
}

SlamOptions Options() {
  SlamOptions options;
  options.tracker.submap_length = 4.0;
  return options;
}

std::string PathOf(const std::string& name) {
  return (fs::temp_directory_path() / ("session_fuzz_" + std::to_string(::getpid()) + "_" + name + ".db")).string();
}

std::string ContentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The file of a session of a few scans.
std::string MakeSession(bool is_finished) {
  const std::string path = PathOf("base");
  Slam slam(Options(), 1);
  auto session = SessionWriter::Create(path, "{}\n", "a recording");
  for (size_t i = 0; i < 24; ++i) {
    const LaserScan scan = Orchard().Scan(i);
    session->Add(FingerprintOf(Scan(scan)), slam.AddScan(scan), slam);
  }
  session->Commit(slam);
  if (is_finished) {
    slam.Finish(false);
    session->Finish(slam, 0.0);
  }
  session.reset();
  std::string content = ContentOf(path);
  fs::remove(path);
  return content;
}

// `frame` with some of the bytes in it changed.
std::string Repacked(std::string_view frame, FuzzedDataProvider* data) {
  std::string bytes = Decompress(frame, "");
  const size_t position = data->ConsumeIntegralInRange<size_t>(0, bytes.size());
  const std::string change = data->ConsumeRandomLengthString(16);
  switch (data->ConsumeIntegralInRange(0, 2)) {
    case 0:
      bytes.replace(position, change.size(), change);
      break;
    case 1:
      bytes.insert(position, change);
      break;
    default:
      bytes.resize(position);
  }
  return Compressor().Compress(bytes);
}

// Replaces a column of a row, or takes the row out.
void Damage(Database* database, FuzzedDataProvider* data) {
  const auto& [table, key] = data->PickValueInArray(kTables);
  const std::string name = table;
  const int64_t num_rows = database->Integer("SELECT count(*) FROM " + name).value();
  const int64_t num_columns = database->Integer("SELECT count(*) FROM pragma_table_info('" + name + "')").value();
  if (num_rows == 0) return;
  const auto row = data->ConsumeIntegralInRange<int64_t>(0, num_rows - 1);
  const std::string at = " WHERE (" + std::string(key) + ") IN (SELECT " + key + " FROM " + name + " ORDER BY " + key +
                         " LIMIT 1 OFFSET " + std::to_string(row) + ")";
  Database::Statement columns(database, "SELECT name FROM pragma_table_info('" + name + "') WHERE cid = ?");
  columns.Bind(data->ConsumeIntegralInRange<int64_t>(0, num_columns - 1));
  CHECK(columns.Step());
  const std::string column = columns.Text(0);
  const int kind = data->ConsumeIntegralInRange(0, 7);
  if (kind == 0) {
    database->Execute("DELETE FROM " + name + at);
    return;
  }
  std::string repacked;
  if (kind > 4) {
    Database::Statement value(database, "SELECT " + column + " FROM " + name + at);
    CHECK(value.Step());
    repacked = Repacked(value.Bytes(0), data);
  }
  Database::Statement update(database, "UPDATE " + name + " SET " + column + " = ?" + at);
  switch (kind) {
    case 1:
      update.Bind(data->ConsumeIntegral<int64_t>());
      break;
    case 2: {
      const auto bits = data->ConsumeIntegral<uint64_t>();
      double real = 0.0;
      std::memcpy(&real, &bits, sizeof(real));
      update.Bind(real);
      break;
    }
    case 3:
      update.BindText(data->ConsumeRandomLengthString(32));
      break;
    case 4:
      update.BindBytes(data->ConsumeRandomLengthString(64));
      break;
    default:
      update.BindBytes(repacked);
  }
  update.Run();
}

void MakeDamaged(const std::string& base, const std::string& path, FuzzedDataProvider* data) {
  std::ofstream(path, std::ios::binary) << base;
  Database database(path, Database::Mode::kWrite);
  for (int i = data->ConsumeIntegralInRange(1, 4); i > 0; --i) {
    try {
      Damage(&database, data);
    } catch (const UserError&) {
      // The table does not take that, or there is nothing packed.
    }
  }
}

std::string BytesOf(const SessionContents& contents) {
  BinaryWriter writer;
  writer(contents.scans, contents.submaps, contents.graph.poses(), contents.graph.constraints());
  for (const Keyframe& keyframe : contents.keyframes) writer(keyframe.is_inserted, keyframe.scan);
  return writer.bytes();
}

}  // namespace
}  // namespace arborslam

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace arborslam;
  static const std::array<std::string, 2> bases = {MakeSession(false), MakeSession(true)};
  static const std::string path = PathOf("damaged");
  static const std::string copy = PathOf("copy");
  FuzzedDataProvider data(bytes, size);
  MakeDamaged(data.PickValueInArray(bases), path, &data);
  try {
    const SessionContents contents = ReadSession(path);
    const SessionContents completed = Completed(contents, Options(), path);
    if (contents.is_finished && !contents.keyframes.empty()) {
      WriteSession(copy, contents);
      CHECK(BytesOf(ReadSession(copy)) == BytesOf(contents));
    }
  } catch (const UserError&) {
    // Said to the user in one line.
  }
  try {
    Slam slam(Options(), 1, ReadTracked(path), path);
    slam.AddScan(Orchard().Scan(24));
  } catch (const UserError&) {
  }
  return 0;
}
