#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace arborslam {
namespace {

TEST(ParallelForTest, EveryIndexOnceForAnyNumberOfThreads) {
  for (const int threads : {-1, 0, 1, 2, 3, 8, 17}) {
    for (const size_t count : {size_t{0}, size_t{1}, size_t{2}, size_t{7}, size_t{1000}}) {
      std::vector<std::atomic<int>> calls(count);
      std::atomic<int> out_of_range{0};
      ParallelFor(count, threads, [&](size_t i) { i < count ? ++calls[i] : ++out_of_range; });
      for (size_t i = 0; i < count; ++i) EXPECT_EQ(calls[i], 1) << "index " << i << ", " << threads << " threads";
      EXPECT_EQ(out_of_range, 0);
    }
  }
}

TEST(ParallelForTest, ReturnsOnlyWhenAllCallsHave) {
  std::vector<int> results(50, 0);
  ParallelFor(results.size(), 4, [&](size_t i) {
    if (i % 7 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    results[i] = static_cast<int>(i) + 1;
  });
  for (size_t i = 0; i < results.size(); ++i) EXPECT_EQ(results[i], static_cast<int>(i) + 1);
}

TEST(ParallelForTest, OneThreadIsTheCaller) {
  const std::thread::id caller = std::this_thread::get_id();
  int elsewhere = 0;
  ParallelFor(20, 1, [&](size_t) { elsewhere += std::this_thread::get_id() != caller; });
  EXPECT_EQ(elsewhere, 0);
}

TEST(ParallelForTest, CallsRunAtTheSameTime) {
  // Each of three calls waits for the other two: it ends early only on three threads.
  std::atomic<int> arrived{0};
  std::atomic<int> met{0};
  ParallelFor(3, 3, [&](size_t) {
    ++arrived;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (arrived < 3 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    if (arrived == 3) ++met;
  });
  EXPECT_EQ(met, 3);
}

}  // namespace
}  // namespace arborslam
