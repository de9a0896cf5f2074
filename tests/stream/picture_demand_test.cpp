// SPDX-License-Identifier: Apache-2.0
#include "server/state/picture_demand.hpp"

#include <gtest/gtest.h>

namespace fanlight::test {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

class PictureDemandTest : public testing::Test {
 protected:
  /// Whether pictures are rendered at this second.
  bool rendered(std::int64_t second, std::size_t displays, bool recording = false) {
    demand_.update(displays, recording, second * kSecondNs);
    EXPECT_EQ(audience_.present(), !demand_.resting());
    return audience_.present();
  }

  Doorbell bell_;
  Audience audience_{bell_};
  PictureDemand demand_{&audience_};
};

TEST_F(PictureDemandTest, RendersUntilTheFirstPictureWasShown) {
  EXPECT_TRUE(rendered(500, 0)) << "a probe may come late";
  demand_.picture_shown(500 * kSecondNs);
  EXPECT_TRUE(rendered(509, 0));
  EXPECT_FALSE(rendered(510, 0));
  demand_.picture_shown(511 * kSecondNs);
  EXPECT_FALSE(rendered(511, 0)) << "a picture that was under way is no reason";
}

TEST_F(PictureDemandTest, RendersForDisplaysAndALittleLonger) {
  demand_.picture_shown(0);
  EXPECT_TRUE(rendered(100, 1)) << "at once";
  EXPECT_TRUE(rendered(200, 2));
  EXPECT_TRUE(rendered(209, 0)) << "a page that is loaded again finds a picture";
  EXPECT_FALSE(rendered(210, 0));
}

TEST_F(PictureDemandTest, RendersForARecordingAndForAScript) {
  demand_.picture_shown(0);
  EXPECT_TRUE(rendered(100, 0, true));
  EXPECT_FALSE(rendered(110, 0));
  demand_.asked(120 * kSecondNs);
  EXPECT_TRUE(rendered(120, 0));
  EXPECT_FALSE(rendered(130, 0));
}

TEST(PictureDemand, NeverRestsWithoutAnAudience) {
  PictureDemand demand(nullptr);
  demand.picture_shown(0);
  EXPECT_FALSE(demand.update(0, false, 1000 * kSecondNs));
  EXPECT_FALSE(demand.resting());
}

}  // namespace
}  // namespace fanlight::test
