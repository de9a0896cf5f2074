// SPDX-License-Identifier: Apache-2.0
// The thread that puts segments on their disk: it follows the open one, and leaves the others once they are
// there.
#include "acquisition/record/segment_sync.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "tests/recording/open_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

void wait_for_syncs(const SegmentSync& sync, std::uint64_t wanted) {
  for (int tries = 0; tries < 1200 && sync.syncs() < wanted; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_GE(sync.syncs(), wanted);
}

TEST(SegmentSync, SyncsAClosedSegmentOnceMoreAndThenTheOpenOneOnly) {
  const TemporaryFolder folder;
  const auto first = std::filesystem::canonical(folder.path()) / "first";
  const auto second = std::filesystem::canonical(folder.path()) / "second";
  std::ofstream(first) << "frames";
  std::ofstream(second) << "frames";
  SegmentSync sync;
  sync.follow({first});
  EXPECT_EQ(open_of(first), 1U);
  wait_for_syncs(sync, 1);
  sync.follow({second});
  EXPECT_EQ(open_of(first), 1U) << "it was written to since its last sync";
  wait_for_syncs(sync, 2);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the count grows before the files are closed
  EXPECT_EQ(open_of(first), 0U);
  EXPECT_EQ(open_of(second), 1U);
  sync.leave();
  EXPECT_EQ(open_of(second), 0U);
  EXPECT_EQ(sync.take_failure(), 0);
}

TEST(SegmentSync, FollowsNoFileThatIsNotThere) {
  const TemporaryFolder folder;
  SegmentSync sync;
  sync.follow({folder / "absent"});
  EXPECT_EQ(sync.take_failure(), 0);
}

}  // namespace
}  // namespace fanlight::test
