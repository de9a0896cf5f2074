// SPDX-License-Identifier: Apache-2.0
// Errors of a private view end that view alone; a lost GPU costs it nothing but time.
#include <algorithm>

#include "tests/gpu/faulty_pipeline.hpp"

namespace fanlight::test::private_fault_tests {
namespace {

constexpr std::uint64_t kSession = 7;

class PrivateFaultTest : public FaultyPipeline {
 protected:
  void SetUp() override {
    start();
    main_ = picture_of(publish(40));
    aside_.camera.yaw_deg = 30;
  }

  void want(std::uint64_t revision, bool open = true) {
    private_views_.draft()[0] = {.view_id = open ? kSession : 0,
                                 .scene = {.revision = revision, .scene = aside_},
                                 .own_camera = own_camera_,
                                 .pictures = &private_pictures_};
    private_views_.publish();
  }
  /// The next private picture of that revision.
  PictureStamp private_picture(std::uint64_t revision) {
    PictureStamp stamp;
    EXPECT_TRUE(eventually([&] {
      read_others();
      const Picture* const newest = private_pictures_.newest();
      if (newest == nullptr || newest->stamp.scene_revision != revision) return false;
      stamp = newest->stamp;
      return true;
    })) << "no private picture of revision "
        << revision;
    return stamp;
  }

  /// The view ends because of this fault, and nothing else does; and it can be opened again.
  void expect_end_of_the_view_alone(const GpuFault& fault, const std::string& reason) {
    inject(fault);
    want(2);
    EXPECT_TRUE(eventually([this] {
      read_others();
      return ends_[0].view_id == kSession;
    }));
    EXPECT_EQ(ends_[0].revision, 2U);
    EXPECT_NE(ends_[0].reason.view().find(reason), std::string::npos) << ends_[0].reason.view();
    EXPECT_EQ(counters_.private_views_refused.value(), 1U);
    EXPECT_EQ(private_pictures_.newest(), nullptr);
    EXPECT_EQ(picture_of(publish(40)).rgba, main_.rgba);
    want(2);
    EXPECT_EQ(picture_of(publish(40)).rgba, main_.rgba);
    EXPECT_EQ(private_pictures_.newest(), nullptr) << "it has ended";
    want(3);
    EXPECT_EQ(private_picture(3).view_id, kSession);
    EXPECT_EQ(counters_.private_views_refused.value(), 1U);
    EXPECT_EQ(counters_.devices_lost.value(), 0U);
    EXPECT_FALSE(failure_);
  }

  Picture main_;
  Scene aside_ = scene_;
  bool own_camera_ = true;
};

TEST_F(PrivateFaultTest, NoCommandPool) {
  expect_end_of_the_view_alone({.call = GpuCall::kCommandPool, .result = VK_ERROR_UNKNOWN},
                               "vkCreateCommandPool");
}

TEST_F(PrivateFaultTest, NoMemory) {
  expect_end_of_the_view_alone({.call = GpuCall::kAllocateMemory, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY},
                               "VK_ERROR_OUT_OF_DEVICE_MEMORY");
}

/// The processor needs no pipeline for the rays.
class PrivateShaderFaultTest : public PrivateFaultTest {
 protected:
  PrivateShaderFaultTest() { sampling_ = Sampling::kTexture; }
};

TEST_F(PrivateShaderFaultTest, NoPipeline) {
  aside_.detector.window_mm *= 2;  // a constant of the shader that casts
  expect_end_of_the_view_alone({.call = GpuCall::kBuildPipeline, .result = VK_ERROR_OUT_OF_HOST_MEMORY},
                               "vkCreateComputePipelines");
}

// A light of its own: its first piece copies the main view's depth map.
TEST_F(PrivateFaultTest, ASubmissionOfALightThatFails) {
  own_camera_ = false;
  aside_ = scene_;
  aside_.light.right_mm += 30;
  expect_end_of_the_view_alone({.call = GpuCall::kSubmit, .result = VK_ERROR_UNKNOWN}, "vkQueueSubmit2");
}

TEST_F(PrivateFaultTest, AShortLackOfMemoryForALightCostsTimeOnly) {
  own_camera_ = false;
  aside_ = scene_;
  aside_.light.right_mm += 30;
  inject({.call = GpuCall::kSubmit, .times = 2, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  want(2);
  EXPECT_EQ(private_picture(2).view_id, kSession);
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  EXPECT_EQ(counters_.private_views_refused.value(), 0U);
}

TEST_F(PrivateFaultTest, ASubmissionThatFails) {
  expect_end_of_the_view_alone({.call = GpuCall::kSubmit, .result = VK_ERROR_UNKNOWN}, "vkQueueSubmit2");
}

TEST_F(PrivateFaultTest, ALossWhileItIsDrawnCostsTheDeviceAndNotTheView) {
  want(2);
  const PictureStamp before = private_picture(2);
  inject({.call = GpuCall::kSubmit});
  aside_.camera.yaw_deg = 20;
  want(3);
  const PictureStamp after = private_picture(3);
  EXPECT_EQ(after.view_id, kSession);
  EXPECT_GT(after.picture_id, before.picture_id);
  EXPECT_EQ(counters_.devices_lost.value(), 1U);
  EXPECT_EQ(counters_.private_views_refused.value(), 0U);
  EXPECT_EQ(picture_of(publish(40)).rgba, main_.rgba);
}

}  // namespace
}  // namespace fanlight::test::private_fault_tests
