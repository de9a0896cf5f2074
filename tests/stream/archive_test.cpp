// SPDX-License-Identifier: Apache-2.0
// Stills on their way to an archive, as far as the server goes: the test takes the place of the queue.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "server/state/still_archive.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"

namespace fanlight::test::archive_tests {
namespace {

using nlohmann::json;

constexpr std::size_t kLargestBody = std::size_t{64} << 10;
constexpr std::size_t kLargestStill = std::size_t{16} << 20;

/// What the test wants of the queue, and what that was given.
struct Wishes {
  Result<void> added;
  bool is_full = false;
  std::atomic<std::size_t> bytes = 0;
};

class FakeQueue : public StillArchive {
 public:
  FakeQueue(std::shared_ptr<Wishes> wishes, std::function<void(std::function<void()>)> post)
      : wishes_(std::move(wishes)), post_(std::move(post)) {}

  Report report() const override { return {.waiting = 3, .refused = 1}; }
  Result<void> add(std::string request, Done done) override {
    if (wishes_->is_full) return Error{ErrorCode::kUnavailable, "full"};
    wishes_->bytes = request.size();
    post_([done = std::move(done), added = wishes_->added] { done(added); });
    return {};
  }

 private:
  std::shared_ptr<Wishes> wishes_;
  std::function<void(std::function<void()>)> post_;
};

class ArchiveTest : public testing::Test {
 protected:
  ServerFixture start() {
    constexpr PictureSize kSize{.width = ServerFixture::kWidth, .height = ServerFixture::kHeight};
    return ServerFixture(
        StreamServer::Config{}, "running", kSize, [this](std::function<void(std::function<void()>)> post) {
          return Result<std::unique_ptr<StillArchive>>(std::make_unique<FakeQueue>(wishes_, std::move(post)));
        });
  }
  std::shared_ptr<Wishes> wishes_ = std::make_shared<Wishes>();
};

TEST_F(ArchiveTest, AServerWithoutAQueueSaysSo) {
  const ServerFixture server;
  EXPECT_EQ(json::parse(talk(server, "GET", "/api/archive").body), json({{"available", false}}));
  const Answer answer = talk(server, "POST", "/api/archive", "{}");
  EXPECT_EQ(answer.status, 409);
  EXPECT_NE(answer.body.find("--archive-queue"), std::string::npos) << answer.body;
  EXPECT_EQ(server.counters().archive_refusals.value(), 1U);
}

TEST_F(ArchiveTest, SaysWhatWaits) {
  const auto server = start();
  EXPECT_EQ(json::parse(talk(server, "GET", "/api/archive").body),
            json({{"available", true}, {"waiting", 3}, {"refused", 1}}));
}

TEST_F(ArchiveTest, AStillMayBeLarge) {
  const auto server = start();
  const std::string body(kLargestStill, ' ');
  EXPECT_EQ(talk(server, "POST", "/api/archive", body).status, 202);
  EXPECT_EQ(wishes_->bytes, body.size());
  EXPECT_EQ(server.counters().archive_stills.value(), 1U);
  EXPECT_EQ(talk(server, "POST", "/api/archive", body + " ").status, 400);
  EXPECT_EQ(server.counters().archive_stills.value(), 1U);
}

TEST_F(ArchiveTest, NothingElseMay) {
  const auto server = start();
  const std::string body(kLargestBody + 1, ' ');
  EXPECT_EQ(talk(server, "PATCH", "/api/scene", body).status, 400);
  EXPECT_EQ(talk(server, "PATCH", "/api/archive", body).status, 400);
  EXPECT_EQ(talk(server, "POST", "/api/archive", "x", "text/plain").status, 415);
}

TEST_F(ArchiveTest, CountsWhatBecomesOfAStill) {
  const auto server = start();
  wishes_->added = Error{ErrorCode::kUnavailable, "the disk is full"};
  const Answer failed = talk(server, "POST", "/api/archive", "{}");
  EXPECT_EQ(failed.status, 503);
  EXPECT_NE(failed.body.find("the disk is full"), std::string::npos);
  wishes_->added = Error{ErrorCode::kBadInput, "no PNG"};
  EXPECT_EQ(talk(server, "POST", "/api/archive", "{}").status, 400);
  wishes_->is_full = true;
  EXPECT_EQ(talk(server, "POST", "/api/archive", "{}").status, 503);
  EXPECT_EQ(server.counters().archive_failures.value(), 2U);
  EXPECT_EQ(server.counters().archive_refusals.value(), 1U);
  EXPECT_EQ(server.counters().archive_stills.value(), 0U);
}

}  // namespace
}  // namespace fanlight::test::archive_tests
