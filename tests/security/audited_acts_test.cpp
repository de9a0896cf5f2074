// SPDX-License-Identifier: Apache-2.0
// What a server writes to its audit log about displays and scripts, under a flood and otherwise.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "proto/base/printable.hpp"
#include "server/access/audit_chain.hpp"
#include "tests/support/audit_lines.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

/// A loopback server with an audit log.
class AuditedServer {
 public:
  const std::filesystem::path& log() const { return log_; }
  ServerFixture& operator*() { return *fixture_; }
  ServerFixture* operator->() { return fixture_.get(); }
  void end() { fixture_.reset(); }

  /// Sends an HTTP request, and returns the answer.
  std::string talk(const std::string& request, const std::string& body = "") {
    boost::asio::io_context loop;
    boost::asio::ip::tcp::socket socket(loop);
    socket.connect(fixture_->endpoint());
    boost::system::error_code end;
    std::string text = request + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n";
    if (!body.empty()) {
      text += "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
    }
    boost::asio::write(socket, boost::asio::buffer(text + "\r\n" + body), end);
    std::string answer;
    boost::asio::read(socket, boost::asio::dynamic_buffer(answer), end);
    return answer;
  }

 private:
  StreamServer::Config config() const {
    StreamServer::Config config;
    config.audit_log = log_;
    return config;
  }

  TemporaryFolder folder_;
  std::filesystem::path log_ = folder_ / "audit.log";
  std::unique_ptr<ServerFixture> fixture_ = std::make_unique<ServerFixture>(config());
};

TEST(AuditedActs, ATakeOverHasALineDuringAFloodOfRefusals) {
  AuditedServer server;
  TestDisplay admin(server->endpoint());
  admin.next(v1::ServerMessage::kHello);
  for (int request = 0; request < 60; ++request) {
    EXPECT_THROW(TestDisplay(server->endpoint(), "https://evil.example"), boost::system::system_error);
  }
  v1::ClientMessage message;
  message.mutable_control()->set_wish(v1::ControlRequest::TAKE_OVER);
  admin.send(message);
  admin.next(v1::ServerMessage::kControlReply);
  const auto lines = audited(server.log(), "control");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0]["result"], "done");
  EXPECT_EQ(lines[0]["details"]["wish"], "TAKE_OVER");
  EXPECT_EQ(audited(server.log(), "refusals").size(), 1U) << "the flood is counted";
}

TEST(AuditedActs, SessionsThatComeAndGoAreFolded) {
  AuditedServer server;
  constexpr int kSessions = 200;
  for (int session = 0; session < kSessions; ++session) {
    TestDisplay display(server->endpoint());
    display.next(v1::ServerMessage::kHello);
  }
  server.end();
  std::uint64_t opened = 0;
  const auto lines = audited(server.log(), "session_opened");
  for (const auto& line : lines) {
    opened += line["result"] == "folded" ? line["details"]["count"].get<std::uint64_t>() : 1;
  }
  EXPECT_EQ(opened, kSessions);
  EXPECT_TRUE(verify_audit_log(server.log()));
}

TEST(AuditedActs, ChangesByScriptsAreFolded) {
  AuditedServer server;
  constexpr int kChanges = 100;
  for (int change = 1; change <= kChanges; ++change) {
    const std::string body = "{\"light\": {\"up_mm\": " + std::to_string(change) + "}}";
    ASSERT_NE(server.talk("PATCH /api/scene", body).find("200 OK"), std::string::npos);
  }
  server.end();
  const auto lines = audited(server.log(), "scene_change");
  std::uint64_t changes = 0;
  for (const auto& line : lines) {
    changes += line["result"] == "folded" ? line["details"]["count"].get<std::uint64_t>() : 1;
  }
  EXPECT_EQ(changes, kChanges);
  const auto& last = lines.back()["details"];
  EXPECT_NE((last.contains("newest") ? last["newest"] : last).dump().find("100"), std::string::npos)
      << "the last value is in the log: " << last;
}

TEST(AuditedActs, ReadingAPictureHasALine) {
  AuditedServer server;
  EXPECT_NE(server.talk("GET /api/picture.png").find("HTTP/1.1 503"), std::string::npos);
  server->show(7, 100);
  std::string answer;
  for (int tries = 0; tries < 200 && answer.find("200 OK") == std::string::npos; ++tries) {
    answer = server.talk("GET /api/picture.png");
  }
  ASSERT_NE(answer.find("200 OK"), std::string::npos);
  for (int more = 0; more < 30; ++more) server.talk("GET /api/picture.png");
  server.end();
  const auto lines = audited(server.log(), "picture_read");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0]["result"], "done");
  EXPECT_EQ(lines[0]["who"], "loopback");
  EXPECT_EQ(lines[0]["details"]["picture"], 7);
  EXPECT_EQ(lines[1]["result"], "folded");
  EXPECT_EQ(lines[1]["details"]["count"], 30);
}

TEST(AuditedActs, ALogThatNobodyReadsHoldsNobodyUp) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const int reader = open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  fcntl(reader, F_SETPIPE_SZ, 4096);
  {
    StreamServer::Config config;
    config.audit_log = folder / "pipe";
    ServerFixture fixture(config);
    // If the loop waited for the pipe, one of these would never be answered.
    for (int number = 0; number < 100; ++number) {
      TestDisplay display(fixture.endpoint());
      display.next(v1::ServerMessage::kHello);
      v1::Scene scene;
      scene.mutable_light()->set_up_mm(number);
      EXPECT_TRUE(display.change(scene).has_in_force());
    }
  }
  close(reader);
}

TEST(AuditedActs, NamesAndOriginsArePrintable) {
  AuditedServer server;
  TestDisplay display(server->endpoint());
  display.next(v1::ServerMessage::kHello);
  for (const char* name : {"a\xC2\x9B"
                           "31m",
                           "\xE2\x80\xAE"
                           "nimda",
                           "a\nb", "\xC2\x85", "a\xE2\x80\x8B"}) {
    v1::ClientMessage message;
    message.mutable_login()->set_name(name);
    display.send(message);
    const std::string refused = display.next(v1::ServerMessage::kError).error().message();
    EXPECT_TRUE(is_printable(refused)) << printable(refused);
  }
  v1::ClientMessage message;
  message.mutable_login()->set_name("Überwachung 手術室");
  display.send(message);
  message.mutable_control()->set_wish(v1::ControlRequest::ASK);
  display.send(message);
  EXPECT_EQ(display.next(v1::ServerMessage::kControlReply).control_reply().state().holder_name(),
            "Überwachung 手術室");
  EXPECT_THROW(TestDisplay(server->endpoint(),
                           "https://\xC2\x9B"
                           "31m\xE2\x80\xAE"),
               boost::system::system_error);
  ASSERT_EQ(audited(server.log(), "request").size(), 1U);
  server.end();
  std::ifstream log(server.log());
  for (std::string line; std::getline(log, line);) EXPECT_TRUE(is_printable(line)) << printable(line);
}

}  // namespace
}  // namespace fanlight::test
