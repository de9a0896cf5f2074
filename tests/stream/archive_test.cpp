// SPDX-License-Identifier: Apache-2.0
// Stills on their way to an archive, as far as the server goes: the test takes the place of the queue.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

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
  Result<ArchivedObject> added = ArchivedObject::kStill;
  bool is_slow = false;  // nothing is ever done
  std::atomic<std::size_t> bytes = 0;
  std::atomic<std::uint64_t> volume_id = 0;
  std::atomic<std::int64_t> acquired_utc_s = 0;
};

class FakeQueue : public StillArchive {
 public:
  FakeQueue(std::shared_ptr<Wishes> wishes, std::function<void(std::function<void()>)> post)
      : wishes_(std::move(wishes)), post_(std::move(post)) {}

  Report report() const override { return {.available = true, .waiting = 3, .refused = 1}; }
  void add(std::string request, Done done) override {
    wishes_->bytes = request.size();
    if (wishes_->is_slow) return kept_.push_back(std::move(done));
    post_([done = std::move(done), added = wishes_->added] { done(added); });
  }
  Result<void> check_volume_request(const std::string& request) const override {
    if (json::parse(request).contains("patient")) return {};
    return Error{ErrorCode::kInvalidArgument, "no patient"};
  }
  void add_volume(VolumeToSend volume, std::string request, Done done) override {
    wishes_->volume_id = volume.volume->stamp().volume_id;
    wishes_->acquired_utc_s = volume.acquired_utc_s;
    wishes_->bytes = request.size();
    if (wishes_->is_slow) return kept_.push_back(std::move(done));
    post_([done = std::move(done)] { done(ArchivedObject::kVolume); });
  }

 private:
  std::shared_ptr<Wishes> wishes_;
  std::function<void(std::function<void()>)> post_;
  std::vector<Done> kept_;
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
  const Answer larger = talk(server, "POST", "/api/archive", body + " ");
  EXPECT_EQ(larger.status, 413);
  EXPECT_NE(larger.body.find("16777216 of body"), std::string::npos) << larger.body;
  EXPECT_EQ(server.counters().archive_stills.value(), 1U);
}

TEST_F(ArchiveTest, NothingElseMay) {
  const auto server = start();
  const std::string body(kLargestBody + 1, ' ');
  EXPECT_EQ(talk(server, "PATCH", "/api/scene", body).status, 413);
  EXPECT_EQ(talk(server, "PATCH", "/api/archive", body).status, 413);
}

/// A request whose header alone is sent; the answer to it.
std::string answer_to_header(const ServerFixture& server, const std::string& header) {
  boost::asio::io_context loop;
  boost::asio::ip::tcp::socket socket(loop);
  socket.connect(server.endpoint());
  boost::asio::write(
      socket, boost::asio::buffer("POST /api/archive HTTP/1.1\r\nHost: localhost\r\n" + header + "\r\n"));
  socket.shutdown(boost::asio::ip::tcp::socket::shutdown_send);
  std::string text;
  boost::system::error_code end;
  boost::asio::read(socket, boost::asio::dynamic_buffer(text), end);
  return text;
}

TEST_F(ArchiveTest, AnswersBeforeTheBodyWhereItRefuses) {
  const auto server = start();
  const std::string type = "Content-Type: application/json\r\n";
  const std::string size = "Content-Length: 16000000\r\n";
  for (const std::string& body :
       {size, size + "Expect: 100-continue\r\n", std::string("Transfer-Encoding: chunked\r\n")}) {
    EXPECT_EQ(answer_to_header(server, body + type + "Origin: http://elsewhere.example\r\n").substr(9, 3),
              "403");
    EXPECT_EQ(answer_to_header(server, body + "Content-Type: text/plain\r\n").substr(9, 3), "415");
  }
  EXPECT_NE(answer_to_header(server, size + type).find("partial message"), std::string::npos)
      << "a body is expected";
  const ServerFixture without;
  EXPECT_EQ(answer_to_header(without, size + type).substr(9, 3), "409");
}

TEST_F(ArchiveTest, TheClientReadsTheRefusalOfALargeBody) {
  const ServerFixture without;
  const Answer answer = talk(without, "POST", "/api/archive", std::string(kLargestStill, ' '));
  EXPECT_EQ(answer.status, 409);
}

TEST_F(ArchiveTest, WritesSomeAtATime) {
  const auto server = start();
  wishes_->is_slow = true;
  boost::asio::io_context loop;
  std::vector<boost::asio::ip::tcp::socket> sockets;
  for (std::size_t i = 0; i < ArchiveSender::kMostRequests; ++i) {
    auto& socket = sockets.emplace_back(loop);
    socket.connect(server.endpoint());
    boost::asio::write(socket, boost::asio::buffer(std::string(
                                   "POST /api/archive HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                                   "application/json\r\nContent-Length: 100\r\n\r\n{")));
  }
  // Once all headers were read.
  while (talk(server, "POST", "/api/archive", "{}").status != 503) {
  }
  EXPECT_GE(server.counters().archive_refusals.value(), 1U);
  sockets.clear();  // their permits end
  wishes_->is_slow = false;
  while (talk(server, "POST", "/api/archive", "{}").status != 202) {
  }
}

TEST_F(ArchiveTest, CountsWhatBecomesOfAStill) {
  const auto server = start();
  wishes_->added = Error{ErrorCode::kUnavailable, "the disk is full"};
  const Answer failed = talk(server, "POST", "/api/archive", "{}");
  EXPECT_EQ(failed.status, 503);
  EXPECT_NE(failed.body.find("the disk is full"), std::string::npos);
  wishes_->added = Error{ErrorCode::kBadInput, "no PNG"};
  EXPECT_EQ(talk(server, "POST", "/api/archive", "{}").status, 400);
  EXPECT_EQ(talk(server, "POST", "/api/archive", "x", "text/plain").status, 415);
  EXPECT_EQ(server.counters().archive_failures.value(), 1U);
  EXPECT_EQ(server.counters().archive_refusals.value(), 2U);
  EXPECT_EQ(server.counters().archive_stills.value(), 0U);
}

/// The answer to a request for this volume while volume 7 is shown, or none.
Answer volume_answer(ServerFixture& server, const json& wanted, bool has_volume = true) {
  const std::string body = json{{"volume", wanted}, {"patient", {{"patient_id", "P1"}}}}.dump();
  auto answer = std::async(std::launch::async, [&] { return talk(server, "POST", "/api/archive", body); });
  if (has_volume) {
    server.answer_fluid(7);
  } else {
    server.answer_volume_order(nullptr);
  }
  return answer.get();
}

TEST_F(ArchiveTest, SendsTheVolumeOnShow) {
  auto server = start();
  EXPECT_EQ(volume_answer(server, "shown").status, 202);
  EXPECT_EQ(wishes_->volume_id, 7U);
  EXPECT_GT(wishes_->acquired_utc_s, 0) << "it is live";
  EXPECT_EQ(volume_answer(server, 7).status, 202);
  EXPECT_EQ(server.counters().archive_volumes.value(), 2U);
  EXPECT_EQ(server.counters().archive_stills.value(), 0U);
}

TEST_F(ArchiveTest, RefusesAVolumeThatIsNotOnShow) {
  auto server = start();
  const Answer other = volume_answer(server, 6);
  EXPECT_EQ(other.status, 409);
  EXPECT_NE(other.body.find("another volume"), std::string::npos) << other.body;
  EXPECT_EQ(volume_answer(server, "shown", false).status, 503);
  for (const json& wrong : {json("next"), json(-1), json(1.5), json(nullptr), json::object()}) {
    const std::string body = json{{"volume", wrong}, {"patient", {{"patient_id", "P1"}}}}.dump();
    EXPECT_EQ(talk(server, "POST", "/api/archive", body).status, 400) << wrong;
  }
  EXPECT_EQ(talk(server, "POST", "/api/archive", R"({"volume": "shown"})").status, 400) << "no patient";
  EXPECT_FALSE(server.has_volume_order());
  // What is frozen, and not drawn, for want of displays.
  server.report_cine({.state = CineStatus::State::kFrozen, .volumes = 2, .volume_id = 6});
  const Answer old = volume_answer(server, "shown");
  EXPECT_EQ(old.status, 503);
  EXPECT_NE(old.body.find("not drawn yet"), std::string::npos) << old.body;
  EXPECT_EQ(server.counters().archive_volumes.value(), 0U);
  EXPECT_EQ(server.counters().archive_refusals.value(), 9U);
}

TEST_F(ArchiveTest, SendsOneVolumeAtATime) {
  auto server = start();
  const std::string body = R"({"volume": "shown", "patient": {"patient_id": "P1"}})";
  wishes_->is_slow = true;  // the first one is never written
  auto first = std::async(std::launch::async, [&] {
    boost::asio::io_context loop;
    boost::asio::ip::tcp::socket socket(loop);
    socket.connect(server.endpoint());
    boost::asio::write(socket,
                       boost::asio::buffer("POST /api/archive HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                                           "application/json\r\nContent-Length: " +
                                           std::to_string(body.size()) + "\r\n\r\n" + body));
    return socket.available();
  });
  server.answer_fluid(7);
  first.get();
  const Answer second = talk(server, "POST", "/api/archive", body);
  EXPECT_EQ(second.status, 503);
  EXPECT_NE(second.body.find("another volume is being written"), std::string::npos) << second.body;
}

TEST_F(ArchiveTest, AServerEndsWhileTheRendererHasNotAnswered) {
  const std::string body = R"({"volume": "shown", "patient": {"patient_id": "P1"}})";
  std::future<int> answer;
  {
    auto server = start();
    answer = std::async(std::launch::async, [&server, body] {
      try {
        return static_cast<int>(talk(server, "POST", "/api/archive", body).status);
      } catch (const std::exception&) {
        return 0;  // the connection was closed
      }
    });
    server.next_order<VolumeOrder>();
  }
  EXPECT_NE(answer.get(), 202);
}

}  // namespace
}  // namespace fanlight::test::archive_tests
