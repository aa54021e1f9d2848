#include "core/io/npz.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

NpyArray SmallArray() { return {{2, 3}, {1.5, -2.25, kInfinity, 1e-300, 0.1, 7.0}}; }

// Reads the array 'a' of an archive whose only entry is `npy`.
NpyArray ReadOnly(const TempFolder& folder, const std::string& npy) {
  return NpzFile(folder.Write("a.npz", HandmadeZip({{"a.npy", npy, {}}}))).Read("a");
}

std::string ErrorOfReading(const std::string& npy) {
  const TempFolder folder;
  return UserErrorOf([&] { ReadOnly(folder, npy); });
}

TEST(Npz, WrittenArraysReadBackExactly) {
  const TempFolder folder;
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, 1e3);
  NpyArray large{{50, 7, 9}, {}};
  for (int i = 0; i < 50 * 7 * 9; ++i) large.values.push_back(normal(random));
  WriteNpz(folder.File("a.npz"),
           {{"small", SmallArray()}, {"large", large}, {"scalar", {{}, {4.0}}}, {"none", {{0, 5}, {}}}});

  const NpzFile file(folder.File("a.npz"));
  EXPECT_THAT(file.Keys(), ElementsAre("large", "none", "scalar", "small"));
  EXPECT_TRUE(file.Has("small"));
  EXPECT_FALSE(file.Has("smal"));
  EXPECT_EQ(file.Read("small").values, SmallArray().values);
  EXPECT_THAT(file.Read("small").shape, ElementsAre(2, 3));
  EXPECT_EQ(file.Read("large").values, large.values);
  EXPECT_EQ(file.Read("large").shape, large.shape);
  EXPECT_THAT(file.Read("scalar").shape, ElementsAre());
  EXPECT_THAT(file.Read("scalar").values, ElementsAre(4.0));
  EXPECT_THAT(file.Read("none").shape, ElementsAre(0, 5));
  EXPECT_THAT(file.Read("none").values, ElementsAre());
}

TEST(Npz, EqualArraysGiveEqualBytes) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), {{"x", SmallArray()}});
  WriteNpz(folder.File("b.npz"), {{"x", SmallArray()}});
  EXPECT_EQ(ReadWhole(folder.File("a.npz")), ReadWhole(folder.File("b.npz")));
}

TEST(Npz, ShapesPrintAsInPython) {
  EXPECT_EQ(NpyArray({{546, 897}, {}}).ShapeText(), "(546, 897)");
  EXPECT_EQ(NpyArray({{546}, {}}).ShapeText(), "(546,)");
  EXPECT_EQ(NpyArray().ShapeText(), "()");
}

TEST(Npz, ConvertsEveryElementType) {
  const TempFolder folder;
  const auto read = [&](const std::string& type, const std::string& data) {
    return ReadOnly(folder, HandmadeNpy(Dictionary(type, "False", "(3,)"), data)).values;
  };
  EXPECT_THAT(read("<f4", RawValues<float>({1.5f, -0.25f, 3e38f})), ElementsAre(1.5, -0.25, 3e38f));
  EXPECT_THAT(read("<f8", RawValues<double>({1.5, -kInfinity, 1e300})), ElementsAre(1.5, -kInfinity, 1e300));
  EXPECT_THAT(read("<i4", RawValues<int32_t>({-1, 0, 2147483647})), ElementsAre(-1.0, 0.0, 2147483647.0));
  EXPECT_THAT(read("<i8", RawValues<int64_t>({-1, 1LL << 40, 5})), ElementsAre(-1.0, 1099511627776.0, 5.0));
}

TEST(Npz, FortranOrderIsTransposed) {
  const TempFolder folder;
  // numpy.asfortranarray([[0, 1, 2], [3, 4, 5]])
  const NpyArray plane =
      ReadOnly(folder, HandmadeNpy(Dictionary("<i4", "True", "(2, 3)"), RawValues<int32_t>({0, 3, 1, 4, 2, 5})));
  EXPECT_THAT(plane.values, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(plane.shape, ElementsAre(2, 3));
  // numpy.asfortranarray(numpy.arange(8).reshape(2, 2, 2))
  const NpyArray cube = ReadOnly(
      folder, HandmadeNpy(Dictionary("<i4", "True", "(2, 2, 2)"), RawValues<int32_t>({0, 4, 2, 6, 1, 5, 3, 7})));
  EXPECT_THAT(cube.values, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  const NpyArray line = ReadOnly(folder, HandmadeNpy(Dictionary("<i4", "True", "(3,)"), RawValues<int32_t>({7, 8, 9})));
  EXPECT_THAT(line.values, ElementsAre(7, 8, 9));
}

TEST(Npz, ReadsHeaderVersions1To3AndPython2Lengths) {
  const TempFolder folder;
  const std::string data = RawValues<double>({1.0, 2.0});
  for (const char version : {1, 2, 3}) {
    EXPECT_THAT(ReadOnly(folder, HandmadeNpy(Dictionary("<f8", "False", "(2,)"), data, version)).values,
                ElementsAre(1.0, 2.0));
  }
  EXPECT_THAT(ReadOnly(folder, HandmadeNpy(Dictionary("<f8", "False", "(2L,)"), data)).values, ElementsAre(1.0, 2.0));
  const std::string reordered = "{\"shape\":(1,2),\"descr\":\"<f8\",\"fortran_order\":False}   ";
  EXPECT_THAT(ReadOnly(folder, HandmadeNpy(reordered, data)).shape, ElementsAre(1, 2));
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(2,)"), data, 4)), HasSubstr("version 4.0"));
}

TEST(Npz, RefusesOtherElementTypes) {
  for (const std::string type : {"<c16", "|O", ">f8", "<f2", "|b1", "<U5", "|u1", "<u8"}) {
    EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary(type, "False", "(1,)"), std::string(16, '\0'))),
                AllOf(HasSubstr("a.npz, array 'a'"), HasSubstr("'" + type + "'"), HasSubstr("float64")));
  }
  EXPECT_THAT(ErrorOfReading(HandmadeNpy("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (1,), }",
                                         std::string(8, '\0'))),
              HasSubstr("record"));
}

TEST(Npz, RefusesMalformedHeaders) {
  const std::string eight(8, '\0');
  for (const std::string dictionary :
       {"", "{", "{}", "{'descr': '<f8'}", "{'descr': '<f8', 'fortran_order': False, 'shape': (1,)",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), } x",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1.0,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': 1}",
        "{'descr': '<f8', 'fortran_order': false, 'shape': (1,)}",
        "{'descr': '<f8', 'descr': '<f8', 'fortran_order': False, 'shape': (1,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), 'extra': 1}",
        "{'descr: '<f8', 'fortran_order': False, 'shape': (1,)}", "{'descr"}) {
    EXPECT_THAT(ErrorOfReading(HandmadeNpy(dictionary, eight)), HasSubstr("malformed .npy header")) << dictionary;
  }
  std::string axes = "(";
  for (int i = 0; i < 100; ++i) axes += "1, ";
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", axes + ")"), eight)), HasSubstr("axes"));
  EXPECT_THAT(ErrorOfReading("\x93NUM"), HasSubstr("too short"));
  EXPECT_THAT(ErrorOfReading("not an array at all"), HasSubstr("not in .npy format"));
  EXPECT_THAT(ErrorOfReading(std::string("\x93NUMPY\1\0\xff\xff{", 11)), HasSubstr("claims 65535 bytes"));
  EXPECT_THAT(ErrorOfReading(std::string("\x93NUMPY\2\0\xff\xff\xff\xff{", 13)), HasSubstr("claims 4294967295 bytes"));
}

TEST(Npz, RefusesShapesThatTheDataDoNotFill) {
  const std::string two = RawValues<double>({1.0, 2.0});
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(3,)"), two)),
              AllOf(HasSubstr("(3,)"), HasSubstr("needs")));
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(1,)"), two)), HasSubstr("(1,)"));
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(0, 7)"), two)), HasSubstr("(0, 7)"));
}

TEST(Npz, RefusesGiganticShapesWithoutAllocatingThem) {
  const std::string eight(8, '\0');
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(1000000000000,)"), eight)),
              HasSubstr("axis is longer"));
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(1000000, 1000000)"), eight)),
              HasSubstr("larger than the 2 GiB"));
  // 2^32 * 2^32 elements: the product overflows to 0.
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(65536, 65536, 65536, 65536)"), eight)),
              HasSubstr("larger than the 2 GiB"));
  EXPECT_THAT(ErrorOfReading(HandmadeNpy(Dictionary("<f8", "False", "(99999999999999999999999999,)"), eight)),
              HasSubstr("axis is longer"));
}

TEST(Npz, RefusesEntriesThatDeclareMoreThanTheyHold) {
  const std::string npy = HandmadeNpy(Dictionary("<f8", "False", "(1,)"), std::string(8, '\0'));
  const std::string large = HandmadeNpy(Dictionary("<f8", "False", "(10000,)"), std::string(8, '\0'));
  const TempFolder folder;
  for (const uint16_t method : {0, 8}) {
    const std::string path = folder.Write("bomb.npz", HandmadeZip({{"a.npy", npy, uint64_t{1} << 40, method}}));
    EXPECT_THAT(UserErrorOf([&] { NpzFile(path).Read("a"); }),
                AllOf(HasSubstr("bomb.npz"), HasSubstr("declares 1099511627776 bytes")));
  }
  // Within the ratio that deflate can reach, so that only the unpacking finds out.
  const std::string path = folder.Write("lie.npz", HandmadeZip({{"a.npy", large, 80000, 8}}));
  EXPECT_THAT(UserErrorOf([&] { NpzFile(path).Read("a"); }), HasSubstr("lie.npz, array 'a'"));
}

TEST(Npz, RefusesADirectoryThatClaimsCountlessEntries) {
  const TempFolder folder;
  const std::string npy = HandmadeNpy(Dictionary("<f8", "False", "(1,)"), std::string(8, '\0'));
  for (const uint64_t count : {uint64_t{2}, uint64_t{1} << 20, uint64_t{1} << 40, ~uint64_t{0}}) {
    const std::string path = folder.Write("many.npz", HandmadeZip({{"a.npy", npy, {}}}, count));
    EXPECT_THAT(UserErrorOf([&] { NpzFile file(path); }), HasSubstr("damaged or incomplete")) << count;
  }
}

TEST(Npz, RefusesOtherCompressionAndArraysGivenTwice) {
  const TempFolder folder;
  const std::string npy = HandmadeNpy(Dictionary("<f8", "False", "(1,)"), std::string(8, '\0'));
  const std::string odd = folder.Write("odd.npz", HandmadeZip({{"a.npy", npy, {}, 12}}));
  EXPECT_THAT(UserErrorOf([&] { NpzFile(odd).Read("a"); }), HasSubstr("method 12"));
  const std::string twice = folder.Write("twice.npz", HandmadeZip({{"a.npy", npy, {}}, {"a.npy", npy, {}}}));
  EXPECT_THAT(UserErrorOf([&] { NpzFile file(twice); }), HasSubstr("'a' twice"));
}

TEST(Npz, PassesOverEntriesThatAreNoArrays) {
  const TempFolder folder;
  const std::string path = folder.Write("a.npz", HandmadeZip({{"readme.txt", "hello", {}}, {".npy", "", {}}}));
  EXPECT_THAT(NpzFile(path).Keys(), ElementsAre());
  EXPECT_THAT(UserErrorOf([&] { NpzFile(path).Read("a"); }), HasSubstr("no arrays"));
}

TEST(Npz, AMissingArrayIsAnsweredWithThoseThereAre) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), {{"time", SmallArray()}, {"scan1", SmallArray()}});
  EXPECT_THAT(UserErrorOf([&] { NpzFile(folder.File("a.npz")).Read("scan0"); }),
              AllOf(HasSubstr("a.npz"), HasSubstr("no array 'scan0'"), HasSubstr("'scan1', 'time'")));
}

TEST(Npz, EachKindOfUnreadablePathHasItsOwnSentence) {
  const TempFolder folder;
  const auto error = [](const std::string& path) { return UserErrorOf([&] { NpzFile file(path); }); };
  EXPECT_THAT(error(folder.File("missing.npz")), AllOf(HasSubstr("missing.npz"), HasSubstr("does not exist")));
  EXPECT_THAT(error(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(error(folder.Write("empty.npz", "")), HasSubstr("is empty"));
  EXPECT_THAT(error(folder.Write("text.npz", "1 2 3\n")), HasSubstr("is not a NumPy zip"));
  EXPECT_THAT(error("/dev/null"), HasSubstr("is not a regular file"));
  EXPECT_THAT(error(folder.Write("file", "x") + "/a.npz"), HasSubstr("Not a directory"));
  const std::string locked = folder.Write("locked.npz", "PK\3\4");
  std::filesystem::permissions(locked, std::filesystem::perms::none);
  // The superuser may read it all the same and then finds no archive.
  EXPECT_THAT(error(locked),
              HasSubstr(::geteuid() == 0 ? "damaged or incomplete" : "cannot be read: Permission denied"));
}

TEST(Npz, ATruncatedArchiveIsAnErrorWhereverItIsCut) {
  const TempFolder folder;
  WriteNpz(folder.File("whole.npz"), {{"a", SmallArray()}, {"b", SmallArray()}});
  const std::string whole = ReadWhole(folder.File("whole.npz"));
  for (size_t sixteenths = 1; sixteenths < 16; ++sixteenths) {
    const std::string path = folder.Write("cut.npz", whole.substr(0, whole.size() * sixteenths / 16));
    EXPECT_THAT(UserErrorOf([&] { NpzFile file(path); }), HasSubstr("damaged or incomplete")) << sixteenths;
  }
  for (size_t size = 0; size < whole.size(); size += 7) {
    const std::string path = folder.Write("cut.npz", whole.substr(0, size));
    EXPECT_THAT(UserErrorOf([&] { NpzFile(path).Read("a"); }), HasSubstr("cut.npz")) << size;
  }
}

TEST(Npz, ADamagedByteIsNeverReadAsOtherValues) {
  const TempFolder folder;
  WriteNpz(folder.File("whole.npz"), {{"a", SmallArray()}});
  const std::string whole = ReadWhole(folder.File("whole.npz"));
  std::mt19937 random(2);
  int num_errors = 0;
  for (size_t position = 0; position < whole.size(); ++position) {
    std::string damaged = whole;
    damaged[position] = static_cast<char>(damaged[position] ^ (1 + random() % 255));
    const std::string path = folder.Write("damaged.npz", damaged);
    try {
      const NpyArray array = NpzFile(path).Read("a");
      EXPECT_EQ(array.values, SmallArray().values) << position;
      EXPECT_EQ(array.shape, SmallArray().shape) << position;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
      ++num_errors;
    }
  }
  EXPECT_GT(num_errors, static_cast<int>(whole.size() / 2));
}

TEST(Npz, AFileThatCannotBeWrittenIsAnError) {
  const TempFolder folder;
  const std::string path = folder.Write("file", "") + "/a.npz";
  EXPECT_THAT(UserErrorOf([&] { WriteNpz(path, {{"a", SmallArray()}}); }), HasSubstr(path));
}

}  // namespace
}  // namespace arborslam
