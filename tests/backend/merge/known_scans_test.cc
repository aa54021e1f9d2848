#include "backend/merge/known_scans.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

TEST(KnownScansTest, HoldsWhatASessionReadAndNothingElse) {
  SessionContents session;
  for (const uint64_t fingerprint : {uint64_t{7}, uint64_t{0}, ~uint64_t{0}}) {
    session.read.push_back({fingerprint, ScanResult()});
  }
  const KnownScans known(session);
  EXPECT_TRUE(known.Hold(7));
  EXPECT_TRUE(known.Hold(~uint64_t{0}));
  EXPECT_FALSE(known.Hold(8));
  // Two scans that are not known need not be the same.
  EXPECT_FALSE(known.Hold(0));
  EXPECT_FALSE(KnownScans().Hold(7));
  EXPECT_FALSE(KnownScans(SessionContents()).Hold(0));
}

}  // namespace
}  // namespace arborslam
