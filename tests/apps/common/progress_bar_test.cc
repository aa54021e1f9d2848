#include "apps/common/progress_bar.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string>

namespace arborslam {
namespace {

constexpr char kEraseLine[] = "\r\x1b[K";

// What a terminal shows in the end of what was written to it.
std::string Visible(const std::string& written) { return written.substr(written.rfind(kEraseLine) + 4); }

TEST(ProgressBarTest, ShowsShareRateAndTimeLeft) {
  std::ostringstream stream;
  double now = 100.0;
  ProgressBar bar(stream, 200, true, [&] { return now; });
  now = 102.0;
  bar.Update(50);
  EXPECT_EQ(Visible(stream.str()), "[#####...............]  25 %  50/200 scans  25.0 scans/s  ETA 0:06");
  now = 5000.0;
  bar.Update(100);
  EXPECT_EQ(Visible(stream.str()), "[##########..........]  50 %  100/200 scans  0.0 scans/s  ETA 1:21:40");
  now = 5001.0;
  bar.Update(250);  // More than was announced.
  EXPECT_EQ(Visible(stream.str()), "[####################] 100 %  250/200 scans  0.1 scans/s  ETA 0:00");
}

TEST(ProgressBarTest, WithoutATotalShowsCountAndRate) {
  for (const std::optional<size_t> total : {std::optional<size_t>(), std::optional<size_t>(0)}) {
    std::ostringstream stream;
    double now = 0.0;
    ProgressBar bar(stream, total, true, [&] { return now; });
    now = 4.0;
    bar.Update(10);
    EXPECT_EQ(Visible(stream.str()), "10 scans  2.5 scans/s");
  }
}

TEST(ProgressBarTest, BeforeTheFirstScanTheTimeLeftIsUnknown) {
  std::ostringstream stream;
  ProgressBar bar(stream, 10, true, [] { return 7.0; });
  bar.Update(0);
  EXPECT_EQ(Visible(stream.str()), "[....................]   0 %  0/10 scans  0.0 scans/s  ETA -");
}

TEST(ProgressBarTest, DrawsAtMostTenTimesASecond) {
  std::ostringstream stream;
  double now = 0.0;
  ProgressBar bar(stream, 100000, true, [&] { return now; });
  for (size_t i = 1; i <= 2000; ++i) {
    now = 0.001 * static_cast<double>(i);
    bar.Update(i);
  }
  const std::string written = stream.str();
  const auto draws = std::count(written.begin(), written.end(), '\r');
  EXPECT_LE(draws, 21);
  EXPECT_GE(draws, 18);
  EXPECT_EQ(written.find('\n'), std::string::npos);
}

TEST(ProgressBarTest, ErasesItselfAtTheEndAlsoAfterAnException) {
  std::ostringstream stream;
  try {
    ProgressBar bar(stream, 10, true);
    bar.Update(5);
    EXPECT_NE(Visible(stream.str()), "");
    throw std::runtime_error("spoilt");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(Visible(stream.str()), "");
}

TEST(ProgressBarTest, ClearMakesRoomForOtherLines) {
  std::ostringstream stream;
  ProgressBar bar(stream, 10, true, [] { return 1.0; });
  bar.Update(5);
  bar.Clear();
  EXPECT_EQ(Visible(stream.str()), "");
  const size_t length = stream.str().size();
  bar.Clear();
  EXPECT_EQ(stream.str().size(), length);
  bar.Update(6);
  EXPECT_NE(Visible(stream.str()), "");
}

TEST(ProgressBarTest, WritesNothingWhenDisabledOrNeverUpdated) {
  std::ostringstream stream;
  {
    ProgressBar disabled(stream, 10, false);
    disabled.Update(5);
    disabled.Clear();
    ProgressBar unused(stream, 10, true);
  }
  EXPECT_EQ(stream.str(), "");
}

}  // namespace
}  // namespace arborslam
