#include "core/io/value_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/simulation/random.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using Numbers = std::vector<int>;

constexpr size_t kBytesOfTen = 8 + 10 * sizeof(int);  // Of ten numbers, as they are written.

Numbers TenFrom(int first) {
  Numbers numbers(10);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

class ValueStoreTest : public testing::Test {
 protected:
  std::shared_ptr<ValueStore> MakeStoreOf(size_t max_bytes) const {
    return std::make_shared<ValueStore>(folder_.path(), max_bytes);
  }

  const TempFolder folder_;
};

TEST_F(ValueStoreTest, KeepsWhatIsWithinTheLimitInMemory) {
  const auto store = MakeStoreOf(3 * kBytesOfTen);
  std::vector<Stored<Numbers>> values;
  for (int i = 0; i < 3; ++i) values.emplace_back(TenFrom(i), store);
  EXPECT_EQ(store->bytes_in_memory(), 3 * kBytesOfTen);
  EXPECT_EQ(store->bytes_in_file(), 0u);
  values.emplace_back(TenFrom(3), store);
  EXPECT_EQ(store->bytes_in_memory(), 3 * kBytesOfTen);
  EXPECT_EQ(store->bytes_in_file(), kBytesOfTen);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(*values[static_cast<size_t>(i)].Get(), TenFrom(i));
}

TEST_F(ValueStoreTest, PutsAwayWhatWasNotAskedForLongest) {
  const auto store = MakeStoreOf(2 * kBytesOfTen);
  const Stored<Numbers> a(TenFrom(1), store);
  const Stored<Numbers> b(TenFrom(2), store);
  a.Get();
  const Stored<Numbers> c(TenFrom(3), store);  // In place of b.
  EXPECT_EQ(store->bytes_in_file(), kBytesOfTen);
  a.Get();
  c.Get();
  EXPECT_EQ(store->bytes_in_file(), kBytesOfTen);
  EXPECT_EQ(*b.Get(), TenFrom(2));  // In place of a, which is written.
  EXPECT_EQ(store->bytes_in_file(), 2 * kBytesOfTen);
  EXPECT_EQ(*a.Get(), TenFrom(1));  // In place of c.
  EXPECT_EQ(*b.Get(), TenFrom(2));
  EXPECT_EQ(*c.Get(), TenFrom(3));
  EXPECT_EQ(store->bytes_in_file(), 3 * kBytesOfTen);  // Each was written once.
}

TEST_F(ValueStoreTest, GivesEverythingBackUnderAnyLimit) {
  for (const size_t limit : {size_t{0}, size_t{100}, size_t{1000}, size_t{100000}}) {
    const auto store = MakeStoreOf(limit);
    Random random(7);
    std::vector<Numbers> expected;
    std::vector<Stored<Numbers>> values;
    for (int step = 0; step < 2000; ++step) {
      const uint64_t choice = random.Bits() >> 33;
      if (values.size() < 10 || choice % 5 == 0) {
        expected.push_back(Numbers(choice % 40, step));
        values.emplace_back(expected.back(), store);
      } else if (choice % 5 == 1) {
        const size_t i = choice / 5 % values.size();
        values.erase(values.begin() + static_cast<std::ptrdiff_t>(i));
        expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(i));
      } else {
        const size_t i = choice / 5 % values.size();
        ASSERT_EQ(*values[i].Get(), expected[i]) << "limit " << limit << ", step " << step;
      }
      // One value alone may be beyond the limit.
      ASSERT_LE(store->bytes_in_memory(), std::max(limit, 8 + 40 * sizeof(int)));
    }
    values.clear();
    EXPECT_EQ(store->bytes_in_memory(), 0u);
  }
}

TEST_F(ValueStoreTest, WhatIsInUseStaysAsItIs) {
  const auto store = MakeStoreOf(0);
  const Stored<Numbers> a(TenFrom(1), store);
  const std::shared_ptr<const Numbers> in_use = a.Get();
  const Stored<Numbers> b(TenFrom(2), store);
  b.Get();
  EXPECT_EQ(*in_use, TenFrom(1));
}

TEST_F(ValueStoreTest, CopiesShareAValue) {
  const auto store = MakeStoreOf(10 * kBytesOfTen);
  Stored<Numbers> copy;
  {
    const Stored<Numbers> value(TenFrom(1), store);
    copy = value;
    EXPECT_EQ(store->bytes_in_memory(), kBytesOfTen);
  }
  EXPECT_EQ(*copy.Get(), TenFrom(1));
  const Stored<Numbers> replaced = copy.Replaced(TenFrom(5));
  EXPECT_EQ(*copy.Get(), TenFrom(1));
  EXPECT_EQ(*replaced.Get(), TenFrom(5));
  EXPECT_EQ(store->bytes_in_memory(), 2 * kBytesOfTen);
  copy = {};
  EXPECT_EQ(store->bytes_in_memory(), kBytesOfTen);
}

TEST_F(ValueStoreTest, WithoutAStoreValuesAreInMemory) {
  EXPECT_TRUE(Stored<Numbers>().Get()->empty());
  const Stored<Numbers> value = TenFrom(4);
  EXPECT_EQ(*value.Get(), TenFrom(4));
  EXPECT_EQ(value.MovedTo(nullptr).Get(), value.Get());
  const auto store = MakeStoreOf(1000);
  const Stored<Numbers> moved = value.MovedTo(store);
  EXPECT_EQ(*moved.Get(), TenFrom(4));
  EXPECT_EQ(store->bytes_in_memory(), kBytesOfTen);
}

TEST_F(ValueStoreTest, IsWrittenAsTheValueIs) {
  BinaryWriter of_value;
  of_value(TenFrom(6));
  BinaryWriter of_stored;
  of_stored(Stored<Numbers>(TenFrom(6), MakeStoreOf(0)));
  EXPECT_EQ(of_stored.bytes(), of_value.bytes());
  Stored<Numbers> read;
  BinaryReader reader(of_value.bytes(), "file");
  reader(read);
  EXPECT_EQ(*read.Get(), TenFrom(6));
}

TEST_F(ValueStoreTest, ServesManyThreads) {
  const auto store = MakeStoreOf(5 * kBytesOfTen);
  std::vector<Stored<Numbers>> values;
  for (int i = 0; i < 50; ++i) values.emplace_back(TenFrom(i), store);
  std::vector<int> num_wrong(4, 0);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < num_wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      Random random(t);
      for (int step = 0; step < 3000; ++step) {
        const int i = static_cast<int>((random.Bits() >> 33) % values.size());
        if (*values[static_cast<size_t>(i)].Get() != TenFrom(i)) ++num_wrong[t];
        if (step % 10 == 0 && *Stored<Numbers>(TenFrom(step), store).Get() != TenFrom(step)) ++num_wrong[t];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(num_wrong, std::vector<int>(4, 0));
}

TEST_F(ValueStoreTest, LeavesNoFileBehind) {
  const auto store = MakeStoreOf(0);
  const Stored<Numbers> a(TenFrom(1), store);
  const Stored<Numbers> b(TenFrom(2), store);
  EXPECT_GT(store->bytes_in_file(), 0u);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(ValueStoreTest, AFolderThatIsNotThereIsAnErrorOnlyWhenItIsNeeded) {
  const auto store = std::make_shared<ValueStore>(folder_.File("none"), kBytesOfTen);
  const Stored<Numbers> a(TenFrom(1), store);
  try {
    const Stored<Numbers> b(TenFrom(2), store);
    ADD_FAILURE() << "no error";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("none"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("memory.max_size"), std::string::npos) << error.what();
  }
  EXPECT_EQ(*a.Get(), TenFrom(1));
  EXPECT_EQ(store->bytes_in_memory(), kBytesOfTen);
}

}  // namespace
}  // namespace arborslam
