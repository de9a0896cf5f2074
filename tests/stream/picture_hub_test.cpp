// SPDX-License-Identifier: Apache-2.0
// PictureHub without sockets: which subscriber is offered which picture, and how often it is encoded.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/stream/picture_hub_rig.hpp"

namespace fanlight::test {
namespace {

TEST_F(PictureHubTest, EncodesOnceForSubscribersWithEqualSettings) {
  SpySubscriber first(1);
  SpySubscriber second(2);
  // The rate of a codec without memory does not change the encoding.
  SpySubscriber slow(3, {.quality = 80, .rate_hz = 0.5});
  SpySubscriber other(4, {.quality = 30});
  for (SpySubscriber* each : {&first, &second, &slow, &other}) hub_.add(*each);
  EXPECT_EQ(hub_.subscriber_count(), 4U);
  show(1);
  EXPECT_EQ(log_.encoded, 2);
  EXPECT_EQ(counters_.pictures_encoded.value(), 2U);
  EXPECT_EQ(first.offers.at(0).message, second.offers.at(0).message);
  EXPECT_EQ(first.offers.at(0).message, slow.offers.at(0).message);
  EXPECT_NE(first.offers.at(0).message, other.offers.at(0).message);
}

TEST_F(PictureHubTest, EncodesNothingWithoutSubscribers) {
  show(1);
  EXPECT_EQ(log_.encoded, 0);
  ASSERT_NE(hub_.newest_picture(), nullptr);
  EXPECT_EQ(hub_.newest_picture()->stamp.picture_id, 1U);
  SpySubscriber slow(1, {.quality = 80, .rate_hz = 1});
  hub_.add(slow);
  EXPECT_EQ(log_.encoded, 1) << "the newest picture";
  pass(kSecondNs / 10);
  show(2);
  EXPECT_EQ(log_.encoded, 1) << "a picture that no rate has due";
}

TEST_F(PictureHubTest, OffersAPrivateViewToItsOwnerOnly) {
  SpySubscriber owner(1);
  SpySubscriber other(2);
  hub_.add(owner);
  hub_.add(other);
  show(1);
  show(50, owner.id());
  EXPECT_EQ(owner.view_id(), owner.id());
  show(2);
  EXPECT_EQ(owner.picture_ids(), (std::vector<std::uint64_t>{1, 50}));
  EXPECT_EQ(owner.offers.back().view_id, owner.id());
  EXPECT_EQ(other.picture_ids(), (std::vector<std::uint64_t>{1, 2}));
  hub_.forget_view(owner);
  EXPECT_EQ(owner.view_id(), 0U);
  EXPECT_EQ(owner.picture_ids(), (std::vector<std::uint64_t>{1, 50, 2}));
  EXPECT_EQ(hub_.newest_picture(owner.id()), nullptr);
}

TEST_F(PictureHubTest, ResyncOffersTheNewestPictureAgain) {
  SpySubscriber subscriber(1);
  hub_.add(subscriber);
  hub_.resync(subscriber);
  EXPECT_TRUE(subscriber.offers.empty()) << "without a picture there is nothing to offer";
  show(1);
  subscriber.set_settings({.quality = 30});
  hub_.resync(subscriber);
  EXPECT_EQ(subscriber.picture_ids(), (std::vector<std::uint64_t>{1, 1}));
  EXPECT_EQ(log_.encoded, 2);
}

TEST_F(PictureHubTest, ResyncOfASharedStreamRequestsAKeyPicture) {
  SpySubscriber first(1, kFilm);
  SpySubscriber late(2, kFilm);
  hub_.add(first);
  show(1);
  EXPECT_TRUE(first.offers.back().key);
  show(2);
  EXPECT_FALSE(first.offers.back().key);

  // The picture is new: the next one becomes the key picture.
  hub_.add(late);
  EXPECT_TRUE(late.offers.empty());
  pass(kSecondNs / 10);
  show(3);
  EXPECT_TRUE(late.offers.at(0).key);
  EXPECT_EQ(first.offers.back().message, late.offers.back().message);

  // The picture has been still for long enough: all subscribers receive it again as a key picture.
  pass(2 * kSecondNs);
  hub_.resync(late);
  EXPECT_EQ(late.picture_ids(), (std::vector<std::uint64_t>{3, 3}));
  EXPECT_TRUE(late.offers.back().key);
  EXPECT_EQ(first.offers.back().message, late.offers.back().message);

  // At most one key picture of a still picture a second.
  const int encoded = log_.encoded;
  pass(kSecondNs * 9 / 10);
  hub_.resync(late);
  EXPECT_EQ(log_.encoded, encoded);
  pass(kSecondNs / 5);
  hub_.resync(late);
  EXPECT_EQ(log_.encoded, encoded + 1);
}

TEST_F(PictureHubTest, ARemovedSubscriberIsOfferedNothing) {
  SpySubscriber stays(1);
  SpySubscriber leaves(2);
  hub_.add(stays);
  hub_.add(leaves);
  show(1);
  show(50, leaves.id());
  hub_.remove(leaves);
  EXPECT_EQ(hub_.subscriber_count(), 1U);
  EXPECT_EQ(hub_.newest_picture(leaves.id()), nullptr);
  show(2);
  EXPECT_EQ(stays.picture_ids(), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(leaves.picture_ids(), (std::vector<std::uint64_t>{1, 50}));
}

TEST_F(PictureHubTest, AnEncodingFailureConcernsItsSubscribersOnly) {
  SpySubscriber good(1);
  SpySubscriber bad(2, {.quality = 13});
  hub_.add(good);
  hub_.add(bad);
  log_.failing_quality = 13;
  show(1);
  EXPECT_EQ(good.picture_ids(), (std::vector<std::uint64_t>{1}));
  EXPECT_EQ(good.failures, 0);
  EXPECT_TRUE(bad.offers.empty());
  EXPECT_EQ(bad.failures, 1);
  hub_.resync(bad);
  EXPECT_EQ(bad.failures, 2);
}

TEST_F(PictureHubTest, WithoutMemoryForAnEncodingTheOthersGoOn) {
  SpySubscriber good(1);
  SpySubscriber bad(2, {.quality = 13});
  hub_.add(good);
  hub_.add(bad);
  log_.quality_without_memory = 13;
  show(1);
  show(2);
  EXPECT_EQ(good.picture_ids(), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_TRUE(bad.offers.empty());
  EXPECT_EQ(bad.failures, 2);
}

TEST_F(PictureHubTest, LimitsTheEncodingsAtATime) {
  show(1);
  std::vector<std::unique_ptr<SpySubscriber>> subscribers;
  for (std::size_t index = 0; index < PictureHub::kMostEncodings; ++index) {
    const StreamSettings settings{.quality = static_cast<int>(index) + 1};
    EXPECT_TRUE(room_for(settings));
    subscribers.push_back(std::make_unique<SpySubscriber>(index + 1, settings));
    hub_.add(*subscribers.back());
  }
  const auto refused = room_for({.quality = 99});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(room_for({.quality = 5})) << "one that exists";
  hub_.remove(*subscribers.back());
  EXPECT_TRUE(room_for({.quality = 99})) << "an encoding without subscribers is dropped";
}

TEST_F(PictureHubTest, ABusyEncodingTakesTheNewestPictureNext) {
  at_once_ = false;
  SpySubscriber viewer(1);
  hub_.add(viewer);
  show(1);
  show(2);
  show(3);
  EXPECT_EQ(jobs_.size(), 1U) << "one job at a time for an encoding";
  finish_jobs();
  EXPECT_EQ(viewer.picture_ids(), (std::vector<std::uint64_t>{1, 3})) << "the one in between is not encoded";
}

TEST_F(PictureHubTest, HeavyEncodingsDoNotDelayQuickOnes) {
  at_once_ = false;
  std::vector<std::unique_ptr<SpySubscriber>> heavy;
  for (std::uint32_t index = 0; index < 15; ++index) {
    heavy.push_back(std::make_unique<SpySubscriber>(
        index + 10,
        StreamSettings{.codec = StreamSettings::Codec::kPng, .most_width = 100 + index, .with_depth = true}));
    hub_.add(*heavy.back());
  }
  SpySubscriber viewer(1);
  hub_.add(viewer);
  show(1);
  ASSERT_EQ(jobs_.size(), 2U) << "one of each lane";
  const auto quick = std::ranges::find(jobs_, EncoderLane::kQuick, &Started::lane);
  ASSERT_NE(quick, jobs_.end());
  quick->work();
  quick->done();
  EXPECT_EQ(viewer.picture_ids(), (std::vector<std::uint64_t>{1})) << "before any heavy one has ended";
  jobs_.erase(quick);
  finish_jobs();
  for (const auto& each : heavy) EXPECT_EQ(each->picture_ids(), (std::vector<std::uint64_t>{1}));
}

TEST_F(PictureHubTest, AnEncodingThatIsDroppedWhileItRunsOffersNothing) {
  at_once_ = false;
  SpySubscriber leaves(1);
  hub_.add(leaves);
  show(1);
  hub_.remove(leaves);
  SpySubscriber comes(2, {.quality = 20});
  hub_.add(comes);  // drops the unused encoding
  finish_jobs();
  EXPECT_TRUE(leaves.offers.empty());
  EXPECT_EQ(comes.picture_ids(), (std::vector<std::uint64_t>{1}));
}

TEST_F(PictureHubTest, APrivateViewThatEndsWhileItIsEncodedIsNotOffered) {
  at_once_ = false;
  SpySubscriber owner(1);
  hub_.add(owner);
  show(1);
  finish_jobs();
  show(50, owner.id());
  hub_.forget_view(owner);
  finish_jobs();
  EXPECT_EQ(owner.picture_ids(), (std::vector<std::uint64_t>{1, 1}));
  EXPECT_EQ(owner.offers.back().view_id, 0U);
}

TEST_F(PictureHubTest, AKeyPictureRequestedWhileAJobRunsComesNext) {
  at_once_ = false;
  SpySubscriber first(1, kFilm);
  hub_.add(first);
  show(1);
  finish_jobs();
  pass(kSecondNs / 10);
  show(2);
  SpySubscriber late(2, kFilm);
  hub_.add(late);  // the job of picture 2 is under way
  finish_jobs();
  EXPECT_FALSE(first.offers.back().key);
  pass(kSecondNs / 10);
  show(3);
  finish_jobs();
  EXPECT_TRUE(late.offers.back().key);
  EXPECT_EQ(late.offers.back().picture_id, 3U);
}

TEST_F(PictureHubTest, ViewersShareFewHeavyEncodings) {
  std::vector<std::unique_ptr<SpySubscriber>> viewers;
  const auto png = [](std::uint32_t width) {
    return StreamSettings{.codec = StreamSettings::Codec::kPng, .most_width = width};
  };
  for (std::uint32_t index = 0; index < PictureHub::kMostHeavyOfViewers; ++index) {
    ASSERT_TRUE(room_for(png(100 + index), false));
    viewers.push_back(std::make_unique<SpySubscriber>(index + 1, png(100 + index)));
    hub_.add(*viewers.back());
    show(index + 1);
  }
  EXPECT_FALSE(room_for(png(50), false));
  EXPECT_TRUE(room_for(png(101), false)) << "one that exists";
  EXPECT_TRUE(room_for({.quality = 30}, false)) << "a quick one";
  EXPECT_TRUE(room_for(png(50), true)) << "of an operator";
}

/// The picture file; empty where it was refused.
std::string file_of(PictureHub& hub) {
  std::string png;
  hub.file({.codec = StreamSettings::Codec::kPng}, [&png](const Result<PictureHub::PictureFile>& file) {
    if (file) png = fmt::format("{}:{}", file->stamp.picture_id, file->bytes->size());
  });
  return png;
}

TEST_F(PictureHubTest, EncodesThePictureFileOnce) {
  show(1);
  EXPECT_EQ(file_of(hub_), "1:16");
  EXPECT_EQ(file_of(hub_), "1:16");
  EXPECT_EQ(log_.encoded, 1);
  show(2);
  EXPECT_EQ(file_of(hub_), "2:16");
}

TEST_F(PictureHubTest, RequestsForThePictureFileAreBounded) {
  at_once_ = false;
  show(1);
  std::size_t made = 0;
  std::size_t refused = 0;
  for (std::size_t request = 0; request < PictureHub::kMostFileRequests + 10; ++request) {
    hub_.file({}, [&](const Result<PictureHub::PictureFile>& file) { ++(file ? made : refused); });
  }
  EXPECT_EQ(refused, 10U);
  finish_jobs();
  EXPECT_EQ(made, PictureHub::kMostFileRequests);
  EXPECT_EQ(log_.encoded, 1);
}

TEST_F(PictureHubTest, PacksASurfaceOnceForAllWhoLightItAndForAllItsLights) {
  const StreamSettings surfaces{.codec = StreamSettings::Codec::kSurface, .quality = 80};
  SpySubscriber first(1, surfaces);
  SpySubscriber second(2, surfaces);
  hub_.add(first);
  hub_.add(second);
  const auto show_surface = [this](std::uint64_t picture_id, std::uint64_t surface_id,
                                   std::uint32_t part_width) {
    Picture& picture = pictures_[0];
    picture.stamp = {.picture_id = picture_id, .surface_id = surface_id};
    picture.stamp.view.part = {.width = part_width, .height = part_width};
    picture.width = picture.height = 2;
    picture.rgba.assign(16, 7);
    picture.depth_mm.assign(4, 30.F);
    picture.certainty.assign(4, 255);
    hub_.show(picture);
    finish_jobs();
  };
  const auto sent = [](const SharedMessage& message) {
    v1::ServerMessage read;
    EXPECT_TRUE(read.ParseFromString(*message));
    return read.picture();
  };
  show_surface(1, 5, 2);
  ASSERT_EQ(first.offers.size(), 1U);
  EXPECT_EQ(first.offers[0].message, second.offers[0].message);
  EXPECT_EQ(first.offers[0].surface_id, 5U);
  const v1::Picture whole = sent(first.offers[0].message);
  EXPECT_FALSE(whole.surface().residuals().empty());
  EXPECT_EQ(whole.jpeg().size(), 0U) << "the surface is all that the picture shows";
  EXPECT_EQ(log_.encoded, 0);
  const v1::Picture outline = sent(first.offers[0].without_surface);
  EXPECT_EQ(outline.surface().surface_id(), 5U);
  EXPECT_EQ(outline.surface().width(), 2U);
  EXPECT_TRUE(outline.surface().runs().empty());

  // Another light, and then another surface.
  pictures_[0].depth_mm.assign(4, 99.F);
  show_surface(2, 5, 2);
  EXPECT_EQ(sent(first.offers[1].message).surface().residuals(), whole.surface().residuals());
  show_surface(3, 6, 2);
  EXPECT_EQ(sent(first.offers[2].message).surface().surface_id(), 6U);

  // Planes beside the surface, and a picture without one.
  show_surface(4, 7, 1);
  EXPECT_EQ(log_.encoded, 1);
  EXPECT_GT(sent(first.offers[3].message).jpeg().size(), 0U);
  EXPECT_EQ(sent(first.offers[3].message).surface().width(), 1U);
  show_surface(5, 8, 0);
  EXPECT_EQ(first.offers[4].surface_id, 0U);
  EXPECT_GT(sent(first.offers[4].message).jpeg().size(), 0U);
  EXPECT_FALSE(sent(first.offers[4].message).has_surface());
}

}  // namespace
}  // namespace fanlight::test
