#include "core/io/g2o.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/input_file.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr char kVertexTag[] = "VERTEX_SE2";
constexpr char kEdgeTag[] = "EDGE_SE2";
constexpr char kFixTag[] = "FIX";
// No survey is that wide or that sure; what is would overflow when it is squared.
constexpr double kMaxCoordinate = 1e9;
constexpr double kMaxInformation = 1e15;

double ReadNumber(const TextReader& reader, size_t index, const std::string& name, double limit) {
  const double value = reader.Number(index, name);
  if (!(std::abs(value) <= limit)) {
    throw UserError(reader.Place(), name + " " + Quoted(reader.fields()[index]) + " is beyond " + ShortestText(limit),
                    "correct or remove the line");
  }
  return value;
}

// The three fields from `index` on.
SE2 ReadPose(const TextReader& reader, size_t index) {
  return SE2(ReadNumber(reader, index, "x", kMaxCoordinate), ReadNumber(reader, index + 1, "y", kMaxCoordinate),
             ReadNumber(reader, index + 2, "theta", kMaxCoordinate));
}

void ReadVertex(const TextReader& reader, PoseGraph2* graph) {
  reader.ExpectFields(5, "VERTEX_SE2 id x y theta");
  const int id = reader.Integer(1, "id");
  if (id < 0) {
    throw UserError(reader.Place(), "has the vertex id " + std::to_string(id), "number vertices from 0");
  }
  if (!graph->vertices.emplace(id, ReadPose(reader, 2)).second) {
    throw UserError(reader.Place(), "gives vertex " + std::to_string(id) + " a second time", "use every id once");
  }
}

PoseGraph2::Edge ReadEdge(const TextReader& reader) {
  reader.ExpectFields(12, "EDGE_SE2 from to x y theta I11 I12 I13 I22 I23 I33");
  PoseGraph2::Edge edge;
  edge.from = reader.Integer(1, "from");
  edge.to = reader.Integer(2, "to");
  if (edge.from == edge.to) {
    throw UserError(reader.Place(), "joins vertex " + std::to_string(edge.from) + " to itself", "remove the line");
  }
  edge.measurement = ReadPose(reader, 3);
  size_t field = 6;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      const std::string name = "I" + std::to_string(row + 1) + std::to_string(column + 1);
      edge.information(row, column) = ReadNumber(reader, field++, name, kMaxInformation);
      edge.information(column, row) = edge.information(row, column);
    }
  }
  if (edge.information.llt().info() != Eigen::Success) {
    throw UserError(reader.Place(), "has an information matrix that is not positive definite",
                    "give the upper triangle of an inverse covariance, row by row");
  }
  return edge;
}

// The vertices that a line holds, each with the line's number.
void ReadFix(const TextReader& reader, std::vector<std::pair<int, size_t>>* fixed) {
  if (reader.fields().size() < 2) reader.ExpectFields(2, "FIX id ...");
  for (size_t i = 1; i < reader.fields().size(); ++i)
    fixed->emplace_back(reader.Integer(i, "id"), reader.line_number());
}

void WritePose(std::ostream& stream, const SE2& pose) {
  stream << ' ' << ShortestText(pose.x()) << ' ' << ShortestText(pose.y()) << ' ' << ShortestText(pose.theta());
}

}  // namespace

bool IsG2oFile(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  if (std::filesystem::path(path).extension() == ".g2o") return true;
  try {
    TextReader reader(path);
    if (!reader.Next()) return false;
    const std::string& tag = reader.fields()[0];
    return tag == kFixTag || tag.rfind("VERTEX_", 0) == 0 || tag.rfind("EDGE_", 0) == 0;
  } catch (const UserError&) {
    return false;  // No text.
  }
}

PoseGraph2 ReadG2o(const std::string& path) {
  TextReader reader(path);
  PoseGraph2 graph;
  std::vector<size_t> edge_lines;
  std::vector<std::pair<int, size_t>> fixed;
  while (reader.Next()) {
    const std::string& tag = reader.fields()[0];
    if (tag == kVertexTag) {
      ReadVertex(reader, &graph);
    } else if (tag == kEdgeTag) {
      graph.edges.push_back(ReadEdge(reader));
      edge_lines.push_back(reader.line_number());
    } else if (tag == kFixTag) {
      ReadFix(reader, &fixed);
    } else {
      throw UserError(reader.Place(), "has the record " + Quoted(tag),
                      "use the supported ones: VERTEX_SE2, EDGE_SE2, FIX");
    }
  }
  if (graph.vertices.empty()) throw UserError(path, "holds no VERTEX_SE2 records", "give a planar pose graph");
  // Only now, because an edge may stand before its vertices.
  for (const auto& [id, line] : fixed) {
    if (graph.vertices.count(id) == 0) {
      throw UserError(reader.Place(line), "fixes vertex " + std::to_string(id) + ", which the file lacks",
                      "add its VERTEX_SE2 record");
    }
    graph.fixed.insert(id);
  }
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    for (const int id : {graph.edges[i].from, graph.edges[i].to}) {
      if (graph.vertices.count(id) == 0) {
        throw UserError(reader.Place(edge_lines[i]), "joins vertex " + std::to_string(id) + ", which the file lacks",
                        "add its VERTEX_SE2 record");
      }
    }
  }
  return graph;
}

void WriteG2o(const std::string& path, const PoseGraph2& graph) {
  AtomicFile file(path);
  std::ostream& stream = file.stream();
  for (const auto& [id, pose] : graph.vertices) {
    stream << kVertexTag << ' ' << id;
    WritePose(stream, pose);
    stream << '\n';
  }
  for (const int id : graph.fixed) stream << kFixTag << ' ' << id << '\n';
  for (const PoseGraph2::Edge& edge : graph.edges) {
    stream << kEdgeTag << ' ' << edge.from << ' ' << edge.to;
    WritePose(stream, edge.measurement);
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) stream << ' ' << ShortestText(edge.information(row, column));
    }
    stream << '\n';
  }
  file.Commit();
}

}  // namespace arborslam
