// SPDX-License-Identifier: Apache-2.0
// Hung or slow, and when a lost GPU is given up. Time is simulated.
#include "renderer/schedule/watchdog.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "renderer/schedule/loss_record.hpp"

namespace fanlight::test {
namespace {

using Pace = Watchdog::Pace;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1000 * kMs;

class WatchdogTest : public testing::Test {
 protected:
  /// Lets time pass while the first lane's newest submission is outstanding, and looks at every step.
  Pace wait(std::int64_t for_ns, std::int64_t step_ns = 100 * kMs) {
    Pace pace = Pace::kUsual;
    for (std::int64_t waited_ns = 0; waited_ns < for_ns; waited_ns += step_ns) {
      now_ns_ += step_ns;
      pace = look(true);
    }
    return pace;
  }
  Pace look(bool outstanding) {
    const std::array lanes = {Watchdog::Lane{.submissions = submissions_, .outstanding = outstanding}};
    return watchdog_.observe(lanes, now_ns_);
  }
  void begin() {
    ++submissions_;
    look(true);
  }
  /// A submission that takes this long.
  void submission(std::int64_t took_ns) {
    begin();
    wait(took_ns);
    EXPECT_EQ(look(false), Pace::kUsual);
  }

  Watchdog watchdog_;
  std::int64_t now_ns_ = 1000 * kSecond;
  std::uint64_t submissions_ = 0;
};

TEST_F(WatchdogTest, SaysSlowLongBeforeItSaysHung) {
  begin();
  EXPECT_EQ(wait(1900 * kMs), Pace::kUsual);
  EXPECT_EQ(wait(200 * kMs), Pace::kSlow);
  EXPECT_EQ(wait(7800 * kMs), Pace::kSlow);
  EXPECT_EQ(wait(200 * kMs), Pace::kHung);
}

TEST_F(WatchdogTest, IsUsualAgainOnceTheSubmissionIsDone) {
  begin();
  EXPECT_EQ(wait(3 * kSecond), Pace::kSlow);
  EXPECT_EQ(look(false), Pace::kUsual);
  begin();
  EXPECT_EQ(wait(kSecond), Pace::kUsual);
}

TEST_F(WatchdogTest, LetsASlowMachineTakeItsTime) {
  struct Row {
    std::int64_t longest_ns;
    std::int64_t slow_after_ns;
    std::int64_t hung_after_ns;
  };
  constexpr Row kRows[] = {{30 * kMs, 2 * kSecond, 10 * kSecond},
                           {400 * kMs, 2 * kSecond, 10 * kSecond},
                           {kSecond, 5 * kSecond, 20 * kSecond},
                           {4 * kSecond, 20 * kSecond, 80 * kSecond},
                           {9 * kSecond, 30 * kSecond, 120 * kSecond}};
  for (const Row& row : kRows) {
    watchdog_ = Watchdog();
    begin();
    wait(row.longest_ns, 10 * kMs);
    look(false);
    EXPECT_EQ(watchdog_.slow_after_ns(), row.slow_after_ns) << row.longest_ns;
    EXPECT_EQ(watchdog_.hung_after_ns(), row.hung_after_ns) << row.longest_ns;
    EXPECT_LE(4 * watchdog_.slow_after_ns(), watchdog_.hung_after_ns());
  }
}

TEST_F(WatchdogTest, ForgetsALongSubmissionAfterManyShortOnes) {
  begin();
  wait(5 * kSecond);
  look(false);
  EXPECT_EQ(watchdog_.hung_after_ns(), 100 * kSecond);
  for (std::size_t each = 0; each < Watchdog::kRecent; ++each) submission(100 * kMs);
  EXPECT_EQ(watchdog_.hung_after_ns(), 10 * kSecond);
}

TEST_F(WatchdogTest, CountsTheTimeInWhichItLooksOnly) {
  begin();
  now_ns_ += 3600 * kSecond;  // the process was stopped
  EXPECT_EQ(look(true), Pace::kUsual);
  EXPECT_EQ(wait(800 * kMs), Pace::kUsual);
  EXPECT_EQ(wait(10 * kSecond), Pace::kHung);
}

TEST_F(WatchdogTest, CountsNoTimeOfRest) {
  submission(100 * kMs);
  now_ns_ += 60 * kSecond;
  begin();
  EXPECT_EQ(wait(kSecond), Pace::kUsual);
}

TEST_F(WatchdogTest, NeedsNoLookBetweenTwoSubmissions) {
  begin();
  wait(9 * kSecond);
  begin();  // the one before was done
  EXPECT_EQ(wait(9 * kSecond), Pace::kUsual) << "the limit has grown";
  EXPECT_EQ(watchdog_.hung_after_ns(), 120 * kSecond);
}

TEST_F(WatchdogTest, WatchesEachLane) {
  std::array<Watchdog::Lane, 3> lanes = {Watchdog::Lane{.submissions = 4, .outstanding = true},
                                         Watchdog::Lane{},
                                         Watchdog::Lane{.submissions = 1, .outstanding = true}};
  Pace pace = watchdog_.observe(lanes, now_ns_);
  for (int step = 0; step < 110; ++step) {
    ++lanes[0].submissions;  // this one continues
    now_ns_ += 100 * kMs;
    pace = watchdog_.observe(lanes, now_ns_);
  }
  EXPECT_EQ(pace, Pace::kHung);
}

TEST(LossRecordTest, GivesUpAtTheThirdLossWithinAMinute) {
  struct Row {
    std::string name;
    std::vector<std::int64_t> at_s;  // with pictures between them
    std::vector<bool> given_up;
  };
  const Row rows[] = {{"one", {5}, {false}},
                      {"three at once", {5, 5, 5}, {false, false, true}},
                      {"three in a minute", {0, 30, 59}, {false, false, true}},
                      {"three in more than a minute", {0, 30, 60}, {false, false, false}},
                      {"one every half minute", {0, 31, 62, 93, 124}, {false, false, false, false, false}},
                      {"then three", {0, 31, 62, 80, 85}, {false, false, false, true, true}}};
  for (const Row& row : rows) {
    LossRecord record;
    for (std::size_t loss = 0; loss < row.at_s.size(); ++loss) {
      record.picture_finished();
      EXPECT_EQ(record.lost(1000 * kSecond + row.at_s[loss] * kSecond), row.given_up[loss])
          << row.name << ", loss " << loss;
    }
  }
}

TEST(LossRecordTest, GivesUpAtTheThirdLossInARowWithoutAPicture) {
  LossRecord record;
  EXPECT_FALSE(record.lost(0));
  EXPECT_FALSE(record.lost(100 * kSecond));
  record.picture_finished();
  EXPECT_FALSE(record.lost(200 * kSecond));
  EXPECT_FALSE(record.lost(300 * kSecond));
  EXPECT_TRUE(record.lost(400 * kSecond));
}

}  // namespace
}  // namespace fanlight::test
