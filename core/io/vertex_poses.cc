#include "core/io/vertex_poses.h"

#include <cstddef>
#include <map>

#include "core/error.h"
#include "core/io/g2o.h"
#include "core/io/text_reader.h"
#include "core/io/trajectory_io.h"

namespace arborslam {
namespace {

constexpr char kLayout[] = "id x y theta";
constexpr size_t kTumColumns = 8;

std::map<int, SE2> ReadTable(const std::string& path) {
  TextReader reader(path);
  std::map<int, SE2> poses;
  size_t num_columns = 0;
  while (reader.Next()) {
    if (num_columns == 0) {
      num_columns = reader.fields().size();
      if (num_columns != 3) reader.ExpectFields(4, kLayout);
    }
    const bool has_id = num_columns == 4;
    reader.ExpectFields(num_columns, has_id ? kLayout : "x y theta");
    const int id = has_id ? reader.Integer(0, "id") : static_cast<int>(poses.size());
    const size_t first = has_id ? 1 : 0;
    const SE2 pose(reader.Number(first, "x"), reader.Number(first + 1, "y"), reader.Number(first + 2, "theta"));
    if (!poses.emplace(id, pose).second) {
      throw UserError(reader.Place(), "gives vertex " + std::to_string(id) + " a second time", "use every id once");
    }
  }
  if (poses.empty()) throw UserError(path, "holds no poses", std::string("write one a line as '") + kLayout + "'");
  return poses;
}

// The columns of the file's first record.
size_t NumColumns(const std::string& path) {
  TextReader reader(path);
  return reader.Next() ? reader.fields().size() : 0;
}

}  // namespace

Trajectory3 ReadVertexPoses(const std::string& path) {
  if (!IsG2oFile(path) && NumColumns(path) == kTumColumns) return ReadTrajectory(path);
  const std::map<int, SE2> poses = IsG2oFile(path) ? ReadG2o(path).vertices : ReadTable(path);
  Trajectory trajectory;
  for (const auto& [id, pose] : poses) {
    trajectory.push_back({static_cast<double>(id), pose});
  }
  return ToTrajectory3(trajectory);
}

}  // namespace arborslam
