// SPDX-License-Identifier: Apache-2.0
// OutgoingQueue: what a session sends next, and which pictures it skips.
#include "server/stream/outgoing_queue.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace fanlight::test {
namespace {

using Item = OutgoingQueue::Item;
using Kind = OutgoingQueue::Item::Kind;

SharedMessage text(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

PictureOffer picture(std::uint64_t picture_id, bool key = true, std::uint64_t scene_revision = 1,
                     std::uint64_t view_id = 0) {
  return {.message = text("picture " + std::to_string(picture_id)),
          .picture_id = picture_id,
          .scene_revision = scene_revision,
          .view_id = view_id,
          .key = key};
}

class OutgoingQueueTest : public testing::Test {
 protected:
  /// Takes and sends all that is due.
  std::vector<Kind> sent_kinds() {
    std::vector<Kind> kinds;
    for (Item item = queue_.next(); item.kind != Kind::kNothing && item.kind != Kind::kNeedsKey;
         item = queue_.next()) {
      kinds.push_back(item.kind);
      queue_.sent();
    }
    return kinds;
  }
  void expect_counts(std::uint64_t offered, std::uint64_t sent, std::uint64_t skipped) {
    EXPECT_EQ(queue_.picture_counts().offered, offered);
    EXPECT_EQ(queue_.picture_counts().sent, sent);
    EXPECT_EQ(queue_.picture_counts().skipped, skipped);
    EXPECT_EQ(counters_.pictures_offered.value(), offered);
    EXPECT_EQ(counters_.pictures_sent.value(), sent);
    EXPECT_EQ(counters_.pictures_skipped.value(), skipped);
  }

  ServerCounters counters_;
  OutgoingQueue queue_{counters_};
};

TEST_F(OutgoingQueueTest, SendsAnswersThenNoticesThenThePicture) {
  queue_.offer(picture(1));
  for (const Notice notice :
       {Notice::kStatistics, Notice::kProbe, Notice::kView, Notice::kScene, Notice::kControl, Notice::kScene})
    queue_.add_notice(notice);
  queue_.add_answer(text("first"));
  queue_.add_answer(text("second"));

  EXPECT_EQ(*queue_.next().message, "first");
  EXPECT_EQ(*queue_.next().message, "second");
  for (const Notice notice :
       {Notice::kControl, Notice::kScene, Notice::kView, Notice::kProbe, Notice::kStatistics}) {
    const Item item = queue_.next();
    EXPECT_EQ(item.kind, Kind::kNotice);
    EXPECT_EQ(item.notice, notice) << "each once, in this order";
  }
  const Item item = queue_.next();
  EXPECT_EQ(item.kind, Kind::kPicture);
  EXPECT_EQ(*item.message, "picture 1");
  queue_.sent();
  EXPECT_EQ(queue_.next().kind, Kind::kNothing);
}

TEST_F(OutgoingQueueTest, HasRoomForALimitedNumberOfAnswers) {
  for (std::size_t answer = 0; answer < OutgoingQueue::kMostAnswers; ++answer) {
    EXPECT_TRUE(queue_.has_room());
    queue_.add_answer(text("answer"));
  }
  EXPECT_FALSE(queue_.has_room());
  queue_.next();
  EXPECT_TRUE(queue_.has_room());
}

TEST_F(OutgoingQueueTest, TheCloseFrameFollowsTheAnswersAndIsTheLast) {
  queue_.offer(picture(1));
  queue_.add_notice(Notice::kScene);
  queue_.add_answer(text("why"));
  queue_.close();
  EXPECT_EQ(sent_kinds(), (std::vector{Kind::kAnswer, Kind::kClose}));
  queue_.add_answer(text("too late"));
  EXPECT_EQ(queue_.next().kind, Kind::kNothing);
}

TEST_F(OutgoingQueueTest, ANewerPictureReplacesTheOneThatWaits) {
  queue_.offer(picture(1));
  queue_.next();  // under way
  queue_.offer(picture(2));
  queue_.offer(picture(3));
  expect_counts(3, 0, 1);
  queue_.sent();
  EXPECT_EQ(*queue_.next().message, "picture 3");
  queue_.sent();
  expect_counts(3, 2, 1);
}

TEST_F(OutgoingQueueTest, OtherMessagesAreNotCountedAsPictures) {
  queue_.add_answer(text("answer"));
  EXPECT_EQ(sent_kinds(), std::vector{Kind::kAnswer});
  expect_counts(0, 0, 0);
}

TEST_F(OutgoingQueueTest, AfterASkippedPictureOnlyAKeyPictureIsTaken) {
  queue_.offer(picture(1));
  queue_.next();
  queue_.offer(picture(2, false));
  queue_.offer(picture(3, false));
  queue_.sent();
  EXPECT_EQ(queue_.next().kind, Kind::kNeedsKey) << "both are skipped";
  queue_.offer(picture(4, false));
  expect_counts(4, 1, 3);
  queue_.offer(picture(5, true));
  EXPECT_EQ(*queue_.next().message, "picture 5");
  queue_.sent();
  queue_.offer(picture(6, false));
  EXPECT_EQ(*queue_.next().message, "picture 6");
}

TEST_F(OutgoingQueueTest, AnotherStreamBeginsWithAKeyPicture) {
  queue_.offer(picture(1));
  queue_.begin_stream(true);
  expect_counts(1, 0, 1);
  EXPECT_EQ(queue_.next().kind, Kind::kNeedsKey);
  queue_.offer(picture(2, false));
  EXPECT_EQ(queue_.next().kind, Kind::kNeedsKey);
  queue_.begin_stream(false);
  EXPECT_EQ(queue_.next().kind, Kind::kNothing);
  queue_.offer(picture(3, false));
  EXPECT_EQ(queue_.next().kind, Kind::kPicture);
}

TEST_F(OutgoingQueueTest, AnnouncesTheFirstPictureThatShowsAChange) {
  queue_.add_shown_request({.view_id = 0, .revision = 5, .request_id = 50});
  queue_.add_shown_request({.view_id = 7, .revision = 2, .request_id = 51});
  queue_.add_shown_request({.view_id = 0, .revision = 6, .request_id = 52});
  queue_.offer(picture(1, true, 4));
  EXPECT_EQ(sent_kinds(), std::vector{Kind::kPicture}) << "an older scene";

  queue_.offer(picture(2, true, 6));
  for (const std::uint64_t request_id : {50U, 52U}) {
    const Item item = queue_.next();
    EXPECT_EQ(item.kind, Kind::kShown);
    EXPECT_EQ(item.shown.request_id, request_id);
    EXPECT_EQ(item.picture_id, 2U);
    queue_.sent();
  }
  EXPECT_EQ(sent_kinds(), std::vector{Kind::kPicture});

  queue_.offer(picture(3, true, 2, 7));
  EXPECT_EQ(sent_kinds(), (std::vector{Kind::kShown, Kind::kPicture})) << "of the private view";
  expect_counts(3, 3, 0);
}

TEST_F(OutgoingQueueTest, AnswersTheOldestOfTooManyShownRequestsWithoutAPicture) {
  for (std::uint64_t request_id = 0; request_id <= OutgoingQueue::kMostShownRequests; ++request_id)
    queue_.add_shown_request({.view_id = 0, .revision = 1, .request_id = request_id});
  const auto given_up = queue_.next();
  EXPECT_EQ(given_up.kind, OutgoingQueue::Item::Kind::kShown);
  EXPECT_EQ(given_up.shown.request_id, 0U);
  EXPECT_EQ(given_up.picture_id, 0U);
  EXPECT_EQ(queue_.next().kind, OutgoingQueue::Item::Kind::kNothing);
  queue_.offer(picture(1));
  EXPECT_EQ(queue_.next().shown.request_id, 1U);
}

TEST_F(OutgoingQueueTest, TheEndSkipsThePicturesThatWaitOrAreUnderWay) {
  queue_.offer(picture(1));
  queue_.next();
  queue_.offer(picture(2));
  queue_.end();
  expect_counts(2, 0, 2);
  queue_.end();
  expect_counts(2, 0, 2);
}

TEST_F(OutgoingQueueTest, SendsASurfaceOnceAndThenPicturesWithoutIt) {
  const auto with_surface = [](std::uint64_t picture_id, std::uint64_t surface_id) {
    PictureOffer offer = picture(picture_id);
    offer.without_surface = text("outline");
    offer.surface_id = surface_id;
    return offer;
  };
  const auto next_text = [this] {
    const Item item = queue_.next();
    queue_.sent();
    return *item.message;
  };
  queue_.offer(with_surface(1, 11));
  EXPECT_EQ(next_text(), "picture 1");
  queue_.offer(with_surface(2, 11));
  EXPECT_EQ(next_text(), "outline") << "the client has this surface";
  queue_.offer(with_surface(3, 12));
  queue_.offer(with_surface(4, 12));
  EXPECT_EQ(next_text(), "picture 4") << "picture 3 with the surface was never sent";
  queue_.offer(picture(5));
  EXPECT_EQ(next_text(), "picture 5");
  queue_.offer(with_surface(6, 12));
  EXPECT_EQ(next_text(), "outline");
  queue_.begin_stream(false);
  queue_.offer(with_surface(7, 12));
  EXPECT_EQ(next_text(), "picture 7") << "another stream begins with its surface";
  expect_counts(7, 6, 1);
}

}  // namespace
}  // namespace fanlight::test
