#include "core/io/binary_archive.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace arborslam {
namespace {

struct Part {
  float number = 0.0f;
  std::vector<int> numbers;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(number, numbers);
  }
};

enum class Colour { kGreen, kRed };

struct Everything {
  bool flag = false;
  Colour colour = Colour::kGreen;
  double number = 0.0;
  std::string text;
  std::vector<Part> parts;
  std::deque<uint64_t> queue;
  std::array<float, 3> three{};
  std::map<NodeId, SE2> poses;
  std::optional<Part> maybe;
  std::optional<int> nothing = 7;
  Eigen::Matrix3d fixed = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd dynamic;
  Eigen::VectorXd vector;
  KeyframeId id;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(flag, colour, number, text, parts, queue, three, poses, maybe, nothing, fixed, dynamic, vector, id);
  }
};

Everything Example() {
  Everything value;
  value.flag = true;
  value.colour = Colour::kRed;
  value.number = -0.1;
  value.text = std::string("a\0b", 3);
  value.parts = {{1.5f, {1, -2}}, {2.5f, {}}};
  value.queue = {7, std::numeric_limits<uint64_t>::max()};
  value.three = {1.0f, 2.0f, 3.0f};
  value.poses = {{KeyframeId{3}, SE2(1.0, 2.0, 3.0)}, {SubmapId{0}, SE2(-1.0, 0.1, -3.1)}};
  value.maybe = Part{4.5f, {9}};
  value.nothing.reset();
  value.fixed << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  value.dynamic.resize(2, 3);
  value.dynamic << 1, 2, 3, 4, 5, 6;
  value.vector = Eigen::Vector2d(0.1, 0.2);
  value.id = KeyframeId{12};
  return value;
}

std::string BytesOf(const Everything& value) {
  BinaryWriter writer;
  writer(value);
  return writer.bytes();
}

TEST(BinaryArchive, ReadsBackWhatItWrote) {
  const std::string bytes = BytesOf(Example());
  Everything read;
  BinaryReader reader(bytes, "file");
  reader(read);
  reader.CheckEnd();
  const Everything value = Example();
  EXPECT_EQ(read.flag, value.flag);
  EXPECT_EQ(read.colour, value.colour);
  EXPECT_EQ(read.number, value.number);
  EXPECT_EQ(read.text, value.text);
  ASSERT_EQ(read.parts.size(), 2u);
  EXPECT_EQ(read.parts[0].number, 1.5f);
  EXPECT_EQ(read.parts[0].numbers, value.parts[0].numbers);
  EXPECT_EQ(read.queue, value.queue);
  EXPECT_EQ(read.three, value.three);
  ASSERT_EQ(read.poses.size(), 2u);
  EXPECT_EQ(read.poses.at(SubmapId{0}).vector(), value.poses.at(SubmapId{0}).vector());
  ASSERT_TRUE(read.maybe.has_value());
  EXPECT_EQ(read.maybe->numbers, value.maybe->numbers);
  EXPECT_FALSE(read.nothing.has_value());
  EXPECT_EQ(read.fixed, value.fixed);
  EXPECT_EQ(read.dynamic, value.dynamic);
  EXPECT_EQ(read.vector, value.vector);
  EXPECT_EQ(read.id, value.id);
  EXPECT_EQ(BytesOf(read), bytes);
}

TEST(BinaryArchive, RefusesWhatIsCutShortAnywhere) {
  const std::string bytes = BytesOf(Example());
  for (size_t size = 0; size < bytes.size(); ++size) {
    Everything read;
    BinaryReader reader(std::string_view(bytes).substr(0, size), "file");
    EXPECT_THROW(reader(read), UserError) << size;
  }
}

TEST(BinaryArchive, RefusesTooMuchAndImpossibleValues) {
  const std::string bytes = BytesOf(Example()) + "x";
  Everything read;
  BinaryReader reader(bytes, "file");
  reader(read);
  EXPECT_THROW(reader.CheckEnd(), UserError);

  bool flag = false;
  EXPECT_THROW(BinaryReader("\x02", "file")(flag), UserError);
  std::vector<double> numbers;
  EXPECT_THROW(BinaryReader(std::string_view("\xff\xff\xff\xff\xff\xff\xff\xff", 8), "file")(numbers), UserError);
  BinaryWriter writer;
  writer(Eigen::Vector3d(1.0, std::numeric_limits<double>::quiet_NaN(), 0.0));
  SE2 pose;
  EXPECT_THROW(BinaryReader(writer.bytes(), "file")(pose), UserError);
}

TEST(BinaryArchive, SurvivesAnyDamage) {
  const std::string bytes = BytesOf(Example());
  for (size_t i = 0; i < bytes.size(); ++i) {
    for (const char value : {'\x00', '\x01', '\x7f', '\xff'}) {
      std::string damaged = bytes;
      damaged[i] = value;
      Everything read;
      BinaryReader reader(damaged, "file");
      try {
        reader(read);
      } catch (const UserError& error) {
        EXPECT_EQ(std::string(error.what()).rfind("file: is damaged: ", 0), 0u) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace arborslam
