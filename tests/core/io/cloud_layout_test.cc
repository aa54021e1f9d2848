#include "core/io/cloud_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Encoding = CloudLayout::Encoding;

std::string ErrorOf(const std::string& contents) {
  return UserErrorOf([&] { ParseCloudHeader("a.pcd", contents); });
}

// A PCD file of one point with `replacement` for the line that begins with `keyword`.
std::string Pcd(const std::string& keyword, const std::string& replacement) {
  std::string contents;
  for (const std::string line : {"VERSION 0.7", "FIELDS x y z t", "SIZE 4 4 4 8", "TYPE F F F U", "COUNT 1 1 1 1",
                                 "WIDTH 1", "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", "POINTS 1", "DATA binary"}) {
    contents += line.substr(0, keyword.size()) == keyword ? replacement : line + "\n";
  }
  return contents + std::string(20, '\1');
}

TEST(ParseCloudHeader, TellsWherePcdFieldsLie) {
  const std::string header =
      "# .PCD v0.7\r\nVERSION 0.7\r\nFIELDS x y _ Z n t\nSIZE 4 8 1 4 2 4\nTYPE F F U F I U\nCOUNT 1 1 3 1 2 1\n"
      "WIDTH 2\nHEIGHT 3\nVIEWPOINT 0 0 0 1 0 0 0\n\nPOINTS 6\nDATA binary\n";
  const CloudLayout layout = ParseCloudHeader("a.pcd", header + std::string(6 * 27 + 5, '\0'));
  EXPECT_EQ(layout.encoding, Encoding::kBinary);
  EXPECT_EQ(layout.num_points, 6u);
  EXPECT_EQ(layout.point_size, 27u);
  EXPECT_EQ(layout.body, header.size());
  ASSERT_NE(layout.Find("z"), nullptr);
  EXPECT_EQ(layout.Find("z")->offset, 15u);
  EXPECT_EQ(layout.Find("z")->type, 'F');
  EXPECT_EQ(layout.Find("t")->offset, 23u);
  EXPECT_EQ(layout.Find("t")->type, 'U');
  EXPECT_EQ(layout.Find("y")->size, 8u);
  EXPECT_EQ(layout.Find("n")->count, 2u);
  EXPECT_EQ(layout.Find("intensity"), nullptr);
}

TEST(ParseCloudHeader, FillsInWhatOldPcdFilesLeaveOut) {
  const CloudLayout layout = ParseCloudHeader("a.pcd", "COLUMNS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n");
  EXPECT_EQ(layout.encoding, Encoding::kText);
  EXPECT_EQ(layout.num_points, 2u);
  EXPECT_EQ(layout.point_size, 3u);
  EXPECT_EQ(layout.Find("z")->offset, 2u);
  EXPECT_EQ(layout.lines_before_body, 3u);
  EXPECT_EQ(ParseCloudHeader("a.pcd", "FIELDS x\nWIDTH 0\nDATA ascii\n").num_points, 0u);
  EXPECT_EQ(ParseCloudHeader("a.pcd", Pcd("POINTS", "")).num_points, 1u);
}

TEST(ParseCloudHeader, RefusesPcdHeadersThatMakeNoSense) {
  EXPECT_EQ(ErrorOf(Pcd("POINTS", "POINTS 1\n")), "(no UserError)") << "The test's own file is sound.";
  EXPECT_THAT(ErrorOf(Pcd("VERSION", "Hello\n")), AllOf(HasSubstr("a.pcd, line 1"), HasSubstr("'Hello'")));
  EXPECT_THAT(ErrorOf(Pcd("HEIGHT", "WIDTH 1\n")), AllOf(HasSubstr("line 7"), HasSubstr("twice")));
  EXPECT_THAT(ErrorOf(Pcd("FIELDS", "")), HasSubstr("no FIELDS"));
  EXPECT_THAT(ErrorOf(Pcd("FIELDS", "FIELDS\n")), HasSubstr("FIELDS says nothing"));
  EXPECT_THAT(ErrorOf(Pcd("SIZE", "SIZE 4 4 4\n")), HasSubstr("SIZE has 3 entries for 4 fields"));
  EXPECT_THAT(ErrorOf(Pcd("TYPE", "TYPE F F F U F\n")), HasSubstr("TYPE has 5 entries"));
  EXPECT_THAT(ErrorOf(Pcd("COUNT", "COUNT 1\n")), HasSubstr("COUNT has 1 entries"));
  EXPECT_THAT(ErrorOf(Pcd("SIZE", "SIZE 4 4 4 3\n")), AllOf(HasSubstr("'t'"), HasSubstr("size 3")));
  EXPECT_THAT(ErrorOf(Pcd("SIZE", "SIZE 4 4 4 -4\n")), HasSubstr("'-4' is no whole number"));
  EXPECT_THAT(ErrorOf(Pcd("SIZE", "SIZE 2 4 4 8\n")), AllOf(HasSubstr("'x'"), HasSubstr("'F' and size 2")));
  EXPECT_THAT(ErrorOf(Pcd("TYPE", "TYPE F F F X\n")), HasSubstr("'X'"));
  EXPECT_THAT(ErrorOf(Pcd("TYPE", "TYPE F F F FF\n")), HasSubstr("'FF'"));
  // A field without values is left out of account.
  EXPECT_EQ(ErrorOf(Pcd("COUNT", "COUNT 1 1 1 0\n")), "(no UserError)");
  EXPECT_THAT(ErrorOf(Pcd("COUNT", "COUNT 1 1 1 18446744073709551615\n")), HasSubstr("18446744073709551615 values"));
  EXPECT_THAT(ErrorOf(Pcd("COUNT", "COUNT 1 1 1 60000\n")), HasSubstr("points are longer"));
  EXPECT_THAT(ErrorOf(Pcd("WIDTH", "WIDTH 99999999999999999999\n")), HasSubstr("no whole number"));
  EXPECT_THAT(ErrorOf(Pcd("WIDTH", "WIDTH 1e3\n")), HasSubstr("'1e3' is no whole number"));
  EXPECT_THAT(ErrorOf(Pcd("HEIGHT", "HEIGHT 2\n")), HasSubstr("WIDTH 1 x HEIGHT 2 are not POINTS 1"));
  EXPECT_THAT(ErrorOf(Pcd("DATA", "DATA binary_zip\n")), AllOf(HasSubstr("line 10"), HasSubstr("'binary_zip'")));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nDATA ascii\n"), HasSubstr("neither POINTS nor WIDTH"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nPOINTS 1\n"), HasSubstr("no complete header"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nPOINTS 1\nDATA ascii"), HasSubstr("no complete header"));
  EXPECT_THAT(ErrorOf(std::string(1 << 20, '#')), HasSubstr("no complete header in its first 65536 bytes"));
  EXPECT_THAT(ErrorOf(std::string(1 << 20, '\n')), HasSubstr("no complete header"));
  EXPECT_THAT(ErrorOf(std::string(100, '\0') + "\n"), HasSubstr("no keyword"));
}

TEST(ParseCloudHeader, RefusesMorePointsThanTheFileHasRoomFor) {
  const auto pcd = [](const std::string& count, const std::string& encoding, const std::string& body) {
    return "FIELDS x y z\nWIDTH " + count + "\nPOINTS " + count + "\nDATA " + encoding + "\n" + body;
  };
  EXPECT_THAT(ErrorOf(pcd("4000000000", "binary", std::string(24, '\1'))), HasSubstr("4000000000 points"));
  EXPECT_THAT(ErrorOf(pcd("16000000", "binary", std::string(24, '\1'))),
              AllOf(HasSubstr("16000000 points"), HasSubstr("room for 2")));
  EXPECT_THAT(ErrorOf(pcd("2", "binary", std::string(23, '\1'))), HasSubstr("room for 1"));
  EXPECT_EQ(ErrorOf(pcd("2", "binary", std::string(24, '\1'))), "(no UserError)");
  EXPECT_EQ(ErrorOf(pcd("2", "binary", std::string(35, '\1'))), "(no UserError)");
  EXPECT_THAT(ErrorOf(pcd("2", "binary", std::string(36, '\1'))), HasSubstr("room for 3"));
  EXPECT_EQ(ErrorOf(pcd("2", "binary", std::string(24, '\1') + std::string(4096, '\0'))), "(no UserError)");
  EXPECT_THAT(ErrorOf(pcd("16000000", "ascii", "1 2 3\n")), HasSubstr("room for 1"));
  EXPECT_EQ(ErrorOf(pcd("2", "ascii", "1 2 3\n1 2 3")), "(no UserError)");
  EXPECT_THAT(ErrorOf(pcd("3", "ascii", "1 2 3\n1 2 3")), HasSubstr("room for 2"));
  // WIDTH x HEIGHT = 2^64 + 2.
  EXPECT_THAT(
      ErrorOf("FIELDS x y z\nWIDTH 6148914691236517206\nHEIGHT 3\nPOINTS 2\nDATA binary\n" + std::string(24, '\1')),
      HasSubstr("are not POINTS 2"));
}

TEST(ParseCloudHeader, RefusesCompressedSizesThatLie) {
  const auto pcd = [](uint32_t packed, uint32_t unpacked, size_t length) {
    return "FIELDS x y z\nWIDTH 100\nPOINTS 100\nDATA binary_compressed\n" + RawValues<uint32_t>({packed, unpacked}) +
           std::string(length, '\1');
  };
  EXPECT_EQ(ErrorOf(pcd(1000, 1200, 1000)), "(no UserError)");
  EXPECT_EQ(ErrorOf(pcd(1000, 1200, 2000)), "(no UserError)");
  EXPECT_THAT(ErrorOf(pcd(1000, 1200, 999)), AllOf(HasSubstr("1000 bytes"), HasSubstr("has 999")));
  EXPECT_THAT(ErrorOf(pcd(4294967295, 1200, 1000)), HasSubstr("4294967295 bytes"));
  EXPECT_THAT(ErrorOf(pcd(1000, 1201, 1000)), AllOf(HasSubstr("1201 bytes"), HasSubstr("1200 by its header")));
  EXPECT_THAT(ErrorOf(pcd(1000, 4294967295, 1000)), HasSubstr("4294967295 bytes"));
  EXPECT_THAT(ErrorOf(pcd(10, 1200, 10)), HasSubstr("10 bytes to 1200"));
  EXPECT_THAT(ErrorOf(pcd(0, 1200, 0)), HasSubstr("0 bytes to 1200"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nPOINTS 1\nDATA binary_compressed\n1234567"), HasSubstr("ends before"));
  EXPECT_EQ(ErrorOf("FIELDS x y z\nPOINTS 0\nDATA binary_compressed\n"), "(no UserError)");
  EXPECT_THAT(ErrorOf("FIELDS x y z _\nPOINTS 1\nDATA binary_compressed\n" + std::string(100, '\1')),
              HasSubstr("unused field"));
}

TEST(ParseCloudHeader, TellsWherePlyPropertiesLie) {
  const std::string header =
      "ply\r\nformat binary_little_endian 1.0\r\ncomment by hand\r\nobj_info num_cols 99999999\r\n"
      "element camera 2\nproperty float view_px\nproperty uchar n\n"
      "element vertex 3\nproperty double x\nproperty float32 y\nproperty float z\nproperty uchar red\n"
      "property uint32 t\nelement face 7\nproperty list uchar int vertex_indices\nend_header\n";
  const CloudLayout layout = ParseCloudHeader("a.ply", header + std::string(10 + 3 * 21 + 100, '\0'));
  EXPECT_EQ(layout.encoding, Encoding::kBinary);
  EXPECT_EQ(layout.num_points, 3u);
  EXPECT_EQ(layout.point_size, 21u);
  EXPECT_EQ(layout.body, header.size() + 10);
  EXPECT_EQ(layout.Find("x")->size, 8u);
  EXPECT_EQ(layout.Find("t")->offset, 17u);
  EXPECT_EQ(layout.Find("t")->type, 'U');
  EXPECT_THAT(ErrorOf(header + std::string(10 + 3 * 21 - 1, '\0')), HasSubstr("room for 2"));
}

TEST(ParseCloudHeader, RefusesPlyHeadersThatMakeNoSense) {
  const auto error = [](const std::string& lines) { return ErrorOf("ply\n" + lines + "end_header\n1 2 3\n"); };
  const std::string format = "format ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(error(format + "element vertex 1\n" + xyz), "(no UserError)");
  EXPECT_THAT(error("element vertex 1\n" + xyz), HasSubstr("no format"));
  EXPECT_THAT(error("format xml 1.0\n"), AllOf(HasSubstr("line 2"), HasSubstr("'xml'")));
  EXPECT_THAT(error(format + format), HasSubstr("out of place"));
  EXPECT_THAT(error(format + xyz), HasSubstr("out of place"));
  EXPECT_THAT(error(format + "element vertex -1\n" + xyz), HasSubstr("'-1'"));
  EXPECT_THAT(error(format + "element vertex 99999999999\n" + xyz), HasSubstr("99999999999 points"));
  EXPECT_THAT(error(format + "element vertex 1000\n" + xyz), HasSubstr("room for 1"));
  EXPECT_THAT(error(format + "element vertex 1\n"), HasSubstr("no properties"));
  EXPECT_THAT(error(format + "element vertex 1\nproperty half x\n"), HasSubstr("'half'"));
  EXPECT_THAT(error(format + "element vertex 1\n" + xyz + "property list uchar int i\n"), HasSubstr("lists"));
  EXPECT_THAT(error(format + "element face 1\nproperty list uchar int i\nelement vertex 1\n" + xyz),
              HasSubstr("lists"));
  EXPECT_THAT(error(format + "element face 1\n"), HasSubstr("no element 'vertex'"));
  EXPECT_THAT(error(format + "element a 99999999999\nproperty int i\nelement vertex 1\n" + xyz),
              HasSubstr("99999999999 points"));
  EXPECT_THAT(error("format binary_little_endian 1.0\nelement a 4611686018427387905\nproperty int i\n"
                    "element vertex 1\n" +
                    xyz),
              HasSubstr("ends before its vertices"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\n"), HasSubstr("no complete header"));
}

TEST(LooksLike, GoesByTheBeginning) {
  EXPECT_TRUE(LooksLikePcd("# .PCD v0.7\n"));
  EXPECT_TRUE(LooksLikePcd("VERSION .7\n"));
  EXPECT_FALSE(LooksLikePcd("# a comment\n"));
  EXPECT_FALSE(LooksLikePcd(""));
  EXPECT_TRUE(LooksLikePly("ply\n"));
  EXPECT_TRUE(LooksLikePly("ply\r\n"));
  EXPECT_FALSE(LooksLikePly("ply"));
  EXPECT_FALSE(LooksLikePly("plywood\n"));
}

}  // namespace
}  // namespace arborslam
