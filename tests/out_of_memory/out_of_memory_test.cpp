// SPDX-License-Identifier: Apache-2.0
// A server that runs out of memory at random places: its connections may end, but it serves on.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/access/audit_chain.hpp"
#include "server/client/stream_client.hpp"
#include "tests/out_of_memory/failing_new.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

/// A display that connects again where it was disconnected.
class StubbornDisplay {
 public:
  explicit StubbornDisplay(std::uint16_t port) : url_("http://127.0.0.1:" + std::to_string(port) + "/") {}

  /// Reads until `body` comes, for `most` at the longest.
  std::optional<Body> next(Body::BodyCase body, std::chrono::milliseconds most) {
    const auto until = std::chrono::steady_clock::now() + most;
    while (std::chrono::steady_clock::now() < until) {
      if (!connected()) continue;
      auto message = client_->next_within(std::chrono::milliseconds(20));
      if (!message) {
        client_.reset();
      } else if (*message && (*message)->body_case() == body) {
        return std::move(**message);
      }
    }
    return std::nullopt;
  }

  void send(const v1::ClientMessage& message) {
    if (client_ != nullptr && !client_->send(message)) client_.reset();
  }

 private:
  bool connected() {
    if (client_ != nullptr) return true;
    auto client = StreamClient::connect({.url = url_});
    if (client) client_ = std::move(*client);
    return client_ != nullptr;
  }

  std::string url_;
  std::unique_ptr<StreamClient> client_;
};

v1::ClientMessage light_change(int step) {
  v1::ClientMessage message;
  message.mutable_scene_change()->set_request_id(static_cast<std::uint64_t>(step));
  message.mutable_scene_change()->mutable_scene()->mutable_light()->set_right_mm(step % 50);
  return message;
}

v1::ClientMessage png_with_depth() {
  v1::ClientMessage message;
  message.mutable_stream()->set_codec(v1::StreamRequest::PNG);
  message.mutable_stream()->set_with_depth(true);
  return message;
}

class OutOfMemoryTest : public testing::TestWithParam<std::uint32_t> {
 protected:
  HasMemory test_thread_;
  TemporaryFolder folder_;
};

TEST_P(OutOfMemoryTest, TheServerServesOn) {
  StreamServer::Config config;
  config.audit_log = folder_ / "audit.log";
  auto fixture = std::make_unique<ServerFixture>(config, "running", ServerFixture::kSurfaceSize);
  StubbornDisplay steady(fixture->endpoint().port());
  StubbornDisplay changing(fixture->endpoint().port());
  constexpr auto kBriefly = std::chrono::milliseconds(10);
  constexpr std::uint64_t kFailuresOfARate = 4;
  std::uint64_t picture = 0;
  const std::uint64_t failed_before = failed_allocations();
  for (const std::uint32_t one_in : {20, 5, 2}) {
    fail_allocations(one_in, GetParam() + one_in);
    const std::uint64_t failed_earlier = failed_allocations();
    const auto start = std::chrono::steady_clock::now();
    // On a busy machine less happens in that time.
    const auto has_failed_enough = [&] {
      const auto passed = std::chrono::steady_clock::now() - start;
      const bool enough = failed_allocations() - failed_earlier > kFailuresOfARate;
      return passed > std::chrono::seconds(15) || (enough && passed > std::chrono::milliseconds(700));
    };
    while (!has_failed_enough()) {
      ++picture;
      fixture->show_surface(picture);
      steady.next(Body::kPicture, kBriefly);
      if (picture % 7 == 0) changing.send(png_with_depth());
      changing.send(light_change(static_cast<int>(picture)));
      changing.next(Body::kSceneReply, kBriefly);
    }
  }
  fail_allocations(0, 0);
  EXPECT_GT(failed_allocations() - failed_before, 3 * kFailuresOfARate);
  const ServerCounters& counters = fixture->counters();
  EXPECT_GT(counters.handlers_out_of_memory.value() + counters.sessions_out_of_memory.value() +
                counters.encodings_failed.value(),
            0U);

  // With memory again, everything works: for those who stayed, and for a new display.
  constexpr auto kLong = std::chrono::seconds(10);
  StubbornDisplay fresh(fixture->endpoint().port());
  for (StubbornDisplay* display : {&steady, &changing, &fresh}) {
    bool shown = false;
    for (int attempt = 0; attempt < 100 && !shown; ++attempt) {
      fixture->show(++picture, 99);
      const auto next = display->next(Body::kPicture, std::chrono::milliseconds(200));
      shown = next && next->picture().picture_id() == picture;
    }
    EXPECT_TRUE(shown);
    display->send(light_change(7));
    EXPECT_TRUE(display->next(Body::kSceneReply, kLong));
    EXPECT_TRUE(display->next(Body::kStatistics, kLong));
  }
  steady = StubbornDisplay(0);
  changing = StubbornDisplay(0);
  fresh = StubbornDisplay(0);
  for (int attempt = 0; attempt < 1000 && counters.sessions_closed.value() < counters.sessions_opened.value();
       ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(counters.sessions_closed.value(), counters.sessions_opened.value());
  EXPECT_EQ(counters.pictures_offered.value(),
            counters.pictures_sent.value() + counters.pictures_skipped.value());
  fixture.reset();
  const auto log = verify_audit_log(folder_ / "audit.log");
  EXPECT_TRUE(log) << log.error().message;
}

INSTANTIATE_TEST_SUITE_P(Seeds, OutOfMemoryTest, testing::Values(1, 2));

}  // namespace
}  // namespace fanlight::test
