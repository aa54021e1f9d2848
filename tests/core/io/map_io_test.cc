#include "core/io/map_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>

#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr uint8_t kUnknown = GridImage::kUnknown;

GridImage SmallGrid() { return {3, 2, 0.05, -1.25, 2.5, {0, 100, kUnknown, 100, 0, 0}}; }

// A description with the line of one key replaced (or, given "", left out).
std::string Description(const std::string& key, const std::string& line) {
  const std::pair<std::string, std::string> lines[] = {{"image", "image: m.pgm"},
                                                       {"resolution", "resolution: 0.1"},
                                                       {"origin", "origin: [1, 2, 0]"},
                                                       {"negate", "negate: 0"},
                                                       {"occupied_thresh", "occupied_thresh: 0.65"},
                                                       {"free_thresh", "free_thresh: 0.196"}};
  std::string text;
  for (const auto& [name, usual] : lines) text += (name == key ? line : usual) + "\n";
  return text;
}

const std::string kPgm = std::string("P5\n2 1\n255\n\x00\xfe", 13);

std::string ErrorOf(const std::string& description, const std::string& pgm) {
  const TempFolder folder;
  folder.Write("m.pgm", pgm);
  const std::string path = folder.Write("m.yaml", description);
  return UserErrorOf([&] { ReadMapServer(path); });
}

TEST(MapServer, PictureHasTheHighestRowOnTopAndTheUsualGreys) {
  const TempFolder folder;
  WriteMapServer(folder.File("orchard.yaml"), SmallGrid());
  EXPECT_THAT(folder.Names(), ElementsAre("orchard.pgm", "orchard.yaml"));
  EXPECT_EQ(ReadWhole(folder.File("orchard.pgm")), std::string("P5\n3 2\n255\n\x00\xfe\xfe\xfe\x00\xcd", 17));
  EXPECT_EQ(ReadWhole(folder.File("orchard.yaml")),
            "image: orchard.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.25, 2.5, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST(MapServer, TrinaryMapsReadBack) {
  const TempFolder folder;
  std::mt19937 random(7);
  const uint8_t states[] = {0, 100, kUnknown};
  GridImage written{37, 23, 0.1, -7.3, 0.1 + 0.2, {}};
  for (int i = 0; i < 37 * 23; ++i) written.occupancy.push_back(states[random() % 3]);
  WriteMapServer(folder.File("a map: #1.yaml"), written);
  const GridImage read = ReadMapServer(folder.File("a map: #1.yaml"));
  EXPECT_EQ(read.width, written.width);
  EXPECT_EQ(read.height, written.height);
  EXPECT_EQ(read.resolution, written.resolution);
  EXPECT_EQ(read.origin_x, written.origin_x);
  EXPECT_EQ(read.origin_y, written.origin_y);
  EXPECT_EQ(read.occupancy, written.occupancy);
}

TEST(MapServer, ProbabilitiesAreSortedByTheThresholds) {
  const TempFolder folder;
  WriteMapServer(folder.File("m.yaml"), {6, 1, 0.1, 0, 0, {19, 20, 50, 65, 66, kUnknown}});
  EXPECT_THAT(ReadMapServer(folder.File("m.yaml")).occupancy,
              ElementsAre(0, kUnknown, kUnknown, kUnknown, 100, kUnknown));
}

TEST(MapServer, ReadsOtherProgramsMaps) {
  const TempFolder folder;
  folder.Write("m.pgm", std::string("P5 # made by hand\n# twice\n 3\t1\n# thrice\n255\n\xff\x00\x80", 47));
  const std::string inverted = folder.Write("m.yaml", Description("negate", "negate: 1"));
  EXPECT_THAT(ReadMapServer(inverted).occupancy, ElementsAre(100, 0, kUnknown));
  std::filesystem::create_directory(folder.File("pictures"));
  std::filesystem::rename(folder.File("m.pgm"), folder.File("pictures/m.pgm"));
  const std::string absolute = folder.Write("n.yaml", Description("image", "image: " + folder.File("pictures/m.pgm")));
  EXPECT_THAT(ReadMapServer(absolute).occupancy, ElementsAre(0, 100, kUnknown));
  EXPECT_EQ(ReadMapServer(absolute).origin_y, 2.0);
}

TEST(MapServer, DamagedDescriptionsAreErrors) {
  for (const std::string key : {"image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"}) {
    EXPECT_THAT(ErrorOf(Description(key, ""), kPgm), AllOf(HasSubstr("m.yaml"), HasSubstr("no key '" + key + "'")));
    EXPECT_THAT(ErrorOf(Description(key, key + ": {a: 1}"), kPgm), HasSubstr("key '" + key + "'"));
  }
  EXPECT_THAT(ErrorOf(Description("resolution", "resolution: coarse"), kPgm), HasSubstr("'coarse'"));
  for (const std::string value : {"0", "-0.1", ".nan", ".inf"}) {
    EXPECT_THAT(ErrorOf(Description("resolution", "resolution: " + value), kPgm), HasSubstr("more than 0")) << value;
  }
  EXPECT_THAT(ErrorOf(Description("origin", "origin: [1, 2]"), kPgm), HasSubstr("three finite numbers"));
  EXPECT_THAT(ErrorOf(Description("origin", "origin: [1, .nan, 0]"), kPgm), HasSubstr("three finite numbers"));
  EXPECT_THAT(ErrorOf(Description("origin", "origin: [1, 2, 0.5]"), kPgm), HasSubstr("yaw 0.5"));
  EXPECT_THAT(ErrorOf(Description("negate", "negate: 2"), kPgm), HasSubstr("value 2"));
  EXPECT_THAT(ErrorOf(Description("free_thresh", "free_thresh: 1.5"), kPgm), HasSubstr("value 1.5"));
  EXPECT_THAT(ErrorOf(Description("free_thresh", "free_thresh: 0.9"), kPgm), HasSubstr("above occupied_thresh"));
  EXPECT_THAT(ErrorOf(Description("", "") + "mode: scale\n", kPgm), HasSubstr("'scale'"));
  EXPECT_EQ(ErrorOf(Description("", "") + "map_type: occupancy\n", kPgm), "(no UserError)");
  EXPECT_EQ(ErrorOf(Description("", ""), kPgm + std::string("\r\n")), "(no UserError)");
  EXPECT_THAT(ErrorOf(Description("", "") + "negate: 0\n", kPgm), HasSubstr("'negate' twice"));
  EXPECT_THAT(ErrorOf("", kPgm), HasSubstr("is empty"));
  EXPECT_THAT(ErrorOf("[1, 2]", kPgm), HasSubstr("not a map description"));
  EXPECT_THAT(ErrorOf("a: [1\n\nb: }", kPgm), AllOf(HasSubstr("m.yaml, line"), HasSubstr("not valid YAML")));
  EXPECT_THAT(ErrorOf(std::string(1 << 20, 'x'), kPgm), HasSubstr("too long"));
  EXPECT_THAT(ErrorOf(Description("image", "image: n.pgm"), kPgm), AllOf(HasSubstr("n.pgm"), HasSubstr("not exist")));
}

TEST(MapServer, DamagedPicturesAreErrors) {
  const std::string description = Description("", "");
  EXPECT_THAT(ErrorOf(description, ""), AllOf(HasSubstr("m.pgm"), HasSubstr("is empty")));
  EXPECT_THAT(ErrorOf(description, "P2\n2 1\n255\n0 1\n"), HasSubstr("not a binary PGM"));
  EXPECT_THAT(ErrorOf(description, std::string("P5\n2 1\n65535\n\0\0\0\0", 17)), HasSubstr("65535"));
  EXPECT_THAT(ErrorOf(description, "P5\n2147483647 2147483647\n255\nxx"), HasSubstr("has 2 bytes of pixels"));
  for (const std::string header : {"P5\n", "P5\n2", "P5\n-2 1\n255\n", "P5\n0 1\n255\n", "P5\n99999999999 1\n255\n",
                                   "P5\n2 1\n255", "P5 # no end", "P5\n2 1\n255xaa"}) {
    EXPECT_THAT(ErrorOf(description, header), HasSubstr("malformed PGM header")) << header;
  }
  for (size_t size = 11; size < kPgm.size(); ++size) {
    EXPECT_THAT(ErrorOf(description, kPgm.substr(0, size)), HasSubstr("bytes of pixels")) << size;
  }
  EXPECT_THAT(ErrorOf(description, kPgm + "x"), HasSubstr("has 3 bytes of pixels where 2 x 1 need 2"));
}

TEST(MapServer, AMapThatCannotBeWrittenLeavesNothingBehind) {
  const TempFolder folder;
  const std::string path = folder.Write("file", "") + "/m.yaml";
  EXPECT_THAT(UserErrorOf([&] { WriteMapServer(path, SmallGrid()); }), HasSubstr("m.pgm"));
  EXPECT_THAT(UserErrorOf([&] { WriteMapServer(folder.File("m.pgm"), SmallGrid()); }), HasSubstr(".yaml"));
  std::filesystem::create_directory(folder.File("m.yaml"));
  EXPECT_THAT(UserErrorOf([&] { WriteMapServer(folder.File("m.yaml"), SmallGrid()); }), HasSubstr("it is a folder"));
  EXPECT_THAT(folder.Names(), ElementsAre("file", "m.yaml"));
}

}  // namespace
}  // namespace arborslam
