// Feeds the reader of g2o files with damaged ones, for libFuzzer: what it takes must be read back alike, what it
// refuses must be a `UserError`. Built with -DARBORSLAM_BUILD_FUZZERS=ON and clang.

#include <glog/logging.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"
#include "core/io/g2o.h"
#include "core/io/vertex_poses.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string base =
      (std::filesystem::temp_directory_path() / ("g2o_fuzz_" + std::to_string(::getpid()))).string();
  const std::string path = base + ".txt";
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  arborslam::IsG2oFile(path);
  try {
    const arborslam::PoseGraph2 graph = arborslam::ReadG2o(path);
    const std::string copy = base + "_copy.txt";
    arborslam::WriteG2o(copy, graph);
    const arborslam::PoseGraph2 read = arborslam::ReadG2o(copy);
    CHECK_EQ(read.vertices.size(), graph.vertices.size());
    CHECK_EQ(read.edges.size(), graph.edges.size());
    CHECK(read.fixed == graph.fixed);
    for (size_t i = 0; i < graph.edges.size(); ++i) {
      CHECK_EQ(read.edges[i].information, graph.edges[i].information);
      CHECK_EQ(read.edges[i].measurement.vector(), graph.edges[i].measurement.vector());
    }
  } catch (const arborslam::UserError&) {
    // Said to the user in one line.
  }
  try {
    arborslam::ReadVertexPoses(path);
  } catch (const arborslam::UserError&) {
  }
  return 0;
}
