// SPDX-License-Identifier: Apache-2.0
// The signals that the server answers.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

#include "server/access/audit_chain.hpp"
#include "tests/support/test_display.hpp"
#include "tests/support/tls_server_fixture.hpp"

namespace fanlight::test {
namespace {

using Clock = std::chrono::steady_clock;

/// The code of the close frame that the display gets.
std::uint16_t close_code(TestDisplay& display) {
  try {
    for (;;) display.next();
  } catch (const boost::system::system_error&) {
    return display.close_code();
  }
}

StreamServer::Config with_log(const std::filesystem::path& path) {
  StreamServer::Config config;
  config.audit_log = path;
  return config;
}

TEST(Signals, TheFirstEndsInGoodOrder) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const TemporaryFolder folder;
    ServerFixture fixture(with_log(folder / "log"));
    std::vector<TestDisplay> displays;
    for (int number = 0; number < 3; ++number) {
      displays.emplace_back(fixture.endpoint()).next(v1::ServerMessage::kHello);
    }
    kill(getpid(), signal);
    for (TestDisplay& display : displays) {
      EXPECT_EQ(close_code(display), 1001);
      EXPECT_EQ(display.close_reason(), "the server is stopping");
    }
    EXPECT_TRUE(fixture.wait_for_end());
    const auto closed = audited(folder / "log", "session_closed", 3);
    ASSERT_EQ(closed.size(), 3U);
    EXPECT_EQ(closed[0]["result"], "the server is stopping");
    EXPECT_TRUE(verify_audit_log(folder / "log"));
  }
}

TEST(Signals, ADisplayThatDoesNotAnswerHoldsTheEndUpForASecond) {
  const TemporaryFolder folder;
  ServerFixture fixture(with_log(folder / "log"));
  TestDisplay display(fixture.endpoint());
  display.next(v1::ServerMessage::kHello);
  const auto began = Clock::now();
  kill(getpid(), SIGTERM);
  EXPECT_TRUE(fixture.wait_for_end());
  EXPECT_GE(Clock::now() - began, std::chrono::milliseconds(900)) << "it had time to answer";
  EXPECT_EQ(close_code(display), 1001) << "it finds the close frame later";
  EXPECT_EQ(audited(folder / "log", "session_closed").size(), 1U);
}

TEST(Signals, TheSecondEndsAtOnce) {
  const TemporaryFolder folder;
  auto config = with_log(folder / "log");
  config.most_end_ms = 120'000;  // the displays do not answer
  ServerFixture fixture(config);
  std::vector<TestDisplay> displays;
  for (int number = 0; number < 3; ++number) {
    displays.emplace_back(fixture.endpoint()).next(v1::ServerMessage::kHello);
  }
  const auto began = Clock::now();
  kill(getpid(), SIGTERM);
  kill(getpid(), SIGTERM);
  EXPECT_TRUE(fixture.wait_for_end());
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(60));
  EXPECT_EQ(audited(folder / "log", "session_closed", 3).size(), 3U);
}

TEST(Signals, AFailureOfTheRendererEndsInGoodOrderToo) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  display.next(v1::ServerMessage::kHello);
  fixture.fail({ErrorCode::kBroken, "the GPU is gone"});
  EXPECT_EQ(close_code(display), 1001);
  const auto ended = fixture.wait_for_end();
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().message, "the GPU is gone");
}

TEST(Signals, HangUpReadsTheFilesAgain) {
  TlsServerFixture guarded;
  const auto viewer = guarded.come_in(Role::kViewer);
  std::filesystem::rename(guarded.file("audit.log"), guarded.file("audit.log.1"));
  kill(getpid(), SIGHUP);
  const auto before = guarded.file("audit.log.1");
  EXPECT_EQ(audited(before, "credentials_read").size(), 1U) << "although the file has not changed";
  EXPECT_EQ(audited(before, "certificates_read").size(), 1U);
  ASSERT_FALSE(guarded.audited("audit").empty());
  EXPECT_EQ(guarded.audited("audit")[0]["result"], "continues");
  EXPECT_TRUE(viewer->next()) << "sessions stay";
  const std::vector<std::filesystem::path> both = {guarded.file("audit.log"), before};
  EXPECT_TRUE(verify_audit_logs(both));
}

TEST(Signals, TheFirstOfTheUserEndsNothing) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  display.next(v1::ServerMessage::kHello);
  kill(getpid(), SIGUSR1);
  v1::Scene scene;
  scene.mutable_light()->set_up_mm(5);
  EXPECT_TRUE(display.change(scene).has_in_force());
}

}  // namespace
}  // namespace fanlight::test
