// SPDX-License-Identifier: Apache-2.0
// What a display may take of the server's time: until it logs in, answers, or goes.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "server/access/credentials.hpp"
#include "tests/support/audit_lines.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

/// Waits up to a minute; whether it came true.
bool comes_true(const std::function<bool()>& condition) {
  for (int attempt = 0; attempt < 6000 && !condition(); ++attempt)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

/// A server with short limits, and an audit log.
class SessionLimitsTest : public testing::Test {
 protected:
  StreamServer::Config config() const {
    StreamServer::Config config;
    config.audit_log = log_;
    config.session_limits = {.login_s = 2, .stalled_s = 1, .unanswered = std::chrono::milliseconds(1000)};
    return config;
  }
  /// Results of the closed sessions in the audit log.
  std::string why_closed() const { return audited(log_, "session_closed").at(0)["result"]; }

  TemporaryFolder folder_;
  std::filesystem::path log_ = folder_ / "audit.log";
};

TEST_F(SessionLimitsTest, ADisplayThatDoesNotLogInIsSentAway) {
  StreamServer::Config config = this->config();
  config.credentials = folder_ / "tokens.toml";
  ASSERT_TRUE(append_token(config.credentials, make_token("test", Role::kViewer, std::nullopt).entry));
  ServerFixture fixture(config);
  const auto begun = std::chrono::steady_clock::now();
  TestDisplay display(fixture.endpoint());
  EXPECT_EQ(display.next().body_case(), v1::ServerMessage::kLoginNeeded);
  EXPECT_THROW(display.next(), boost::system::system_error);
  EXPECT_EQ(display.close_code(), 1008);
  EXPECT_EQ(display.close_reason(), "no token was received");
  // The server counts whole seconds.
  EXPECT_GT(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(900));
  EXPECT_EQ(fixture.counters().sessions_opened.value(), 0U);
}

TEST_F(SessionLimitsTest, ADisplayThatAnswersNoPingIsCutAndTheLogSaysSo) {
  ServerFixture fixture(config());
  TestDisplay silent(fixture.endpoint());  // reads nothing from now on, so its library answers nothing
  silent.next(v1::ServerMessage::kHello);
  EXPECT_TRUE(comes_true([&] { return fixture.counters().sessions_unanswered.value() == 1; }));
  EXPECT_EQ(why_closed(), "it answered no ping for 1 s");
}

TEST_F(SessionLimitsTest, ADisplayThatAnswersNoPingWhileAPictureIsUnderWayIsCutForThat) {
  StreamServer::Config patient = config();
  patient.session_limits.stalled_s = 600;
  ServerFixture fixture(patient, "running", ServerFixture::kNoiseSize);
  TestDisplay silent(fixture.endpoint());
  silent.next(v1::ServerMessage::kHello);
  // More bytes than the sockets hold: the time-out ends a write and a read.
  std::uint64_t picture = 0;
  EXPECT_TRUE(comes_true([&] {
    fixture.show_noise(++picture);
    return fixture.counters().sessions_closed.value() == 1;
  }));
  EXPECT_EQ(fixture.counters().sessions_unanswered.value(), 1U);
  EXPECT_EQ(why_closed(), "it answered no ping for 1 s");
}

TEST_F(SessionLimitsTest, ADisplayThatAnswersPingsStays) {
  ServerFixture fixture(config());
  TestDisplay display(fixture.endpoint());
  for (int seconds = 0; seconds < 3; ++seconds) display.next(v1::ServerMessage::kStatistics);
  EXPECT_EQ(fixture.counters().sessions_unanswered.value(), 0U);
}

TEST_F(SessionLimitsTest, ADisplayThatIsToldToGoAndDoesNotIsCut) {
  StreamServer::Config patient = config();
  patient.session_limits.unanswered = std::chrono::minutes(10);
  ServerFixture fixture(patient);
  TestDisplay rude(fixture.endpoint());
  rude.next(v1::ServerMessage::kHello);
  for (int ping = 0; ping < 10 * InputBudget::kPingsPerSecond; ++ping) rude.ping();
  EXPECT_TRUE(comes_true([&] { return fixture.counters().sessions_closed.value() == 1; }));
  EXPECT_EQ(why_closed(), "over 20 pings within a second");
}

TEST_F(SessionLimitsTest, ADisplayThatTakesNothingIsCut) {
  StreamServer::Config patient = config();
  patient.session_limits.unanswered = std::chrono::minutes(10);
  ServerFixture fixture(patient, "running", ServerFixture::kNoiseSize);
  TestDisplay stopped(fixture.endpoint());
  stopped.next(v1::ServerMessage::kHello);
  // More bytes than the sockets hold.
  std::uint64_t picture = 0;
  EXPECT_TRUE(comes_true([&] {
    fixture.show_noise(++picture);
    return fixture.counters().sessions_stalled.value() == 1;
  }));
  EXPECT_EQ(why_closed(), "it took nothing for 1 s");
}

TEST(SessionLimits, TheMemoryOfASessionIsBounded) {
  // A message of 1 MiB, 16 answers of 128 KiB, and two pictures of 512 x 512 with their depth maps.
  EXPECT_EQ(SessionLimits::most_bytes({512, 512}),
            (1U << 20) + (16U << 17) + (112U << 10) + 2U * 8 * 512 * 512);
}

}  // namespace
}  // namespace fanlight::test
