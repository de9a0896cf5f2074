// SPDX-License-Identifier: Apache-2.0
// The stream by RTP of a running server, to sockets of this machine.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/rtp/h264_payloads.hpp"
#include "server/rtp/user_data_sei.hpp"
#include "tests/rtp/rtp_receiver.hpp"
#include "tests/stream/h264_reader.hpp"
#include "tests/support/audit_lines.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace rtp_sender_tests {

using nlohmann::json;

StreamServer::Config sending_to(const RtpReceiver& receiver, bool at_start = true) {
  StreamServer::Config config;
  config.rtp = RtpSender::Config{.host = "127.0.0.1", .port = receiver.port(), .at_start = at_start};
  return config;
}

template <typename Holds>
bool soon(Holds holds) {
  for (int i = 0; i < 500 && !holds(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return holds();
}

/// What came as one picture.
struct Received {
  std::vector<std::vector<std::uint8_t>> units;

  bool key() const {
    return std::ranges::any_of(units, [](const auto& unit) { return nal_kind(unit) == NalKind::kKeySlice; });
  }
  json data() const {
    for (const auto& unit : units) {
      if (const auto text = read_user_data_sei(unit)) return json::parse(*text);
    }
    return {};
  }
  /// Middle of the luma; -1: it cannot be decoded.
  int grey(H264Reader& reader) const {
    Bytes stream;
    for (const auto& unit : units) {
      stream.insert(stream.end(), {0, 0, 0, 1});
      stream.insert(stream.end(), unit.begin(), unit.end());
    }
    const Bytes luma = reader.luma(stream);
    return luma.empty() ? -1 : luma[luma.size() / 2];
  }
};

Received next_picture(RtpReceiver& receiver) {
  return {unpacked(receiver.next_picture())};
}

Answer wish(const ServerFixture& server, const std::string& word) {
  return talk(server, "POST", "/api/rtp", json{{"wish", word}}.dump());
}

std::vector<std::uint8_t> picture_loss() {
  return {0x81, 206, 0, 2, 0, 0, 0, 9, 0, 0, 0, 0};
}

TEST(RtpSender, SendsEachPictureWithWhatIsKnownOfIt) {
  RtpReceiver receiver;
  ServerFixture server(sending_to(receiver));
  H264Reader reader;
  std::uint32_t last_timestamp = 0;
  for (std::uint64_t id = 1; id <= 5; ++id) {
    server.show({.picture_id = id,
                 .volume = {.volume_id = 70 + id, .last_capture_time_ns = now_ns()},
                 .view = {.right = {1, 0, 0}, .down = {0, 0, -1}, .forward = {0, 1, 0}, .mm_per_pixel = 0.25},
                 .finished_time_ns = now_ns()},
                static_cast<std::uint8_t>(40 * id));
    const Received picture = next_picture(receiver);
    ASSERT_FALSE(picture.units.empty()) << "picture " << id;
    EXPECT_EQ(picture.key(), id == 1);
    EXPECT_NEAR(picture.grey(reader), 16 + static_cast<int>(40 * id) * 219 / 255, 3);
    const json data = picture.data();
    ASSERT_TRUE(data.is_object());
    EXPECT_EQ(data["picture"]["picture_id"], std::to_string(id));  // JSON has no 64 bit integers
    EXPECT_EQ(data["picture"]["volume_id"], std::to_string(70 + id));
    EXPECT_EQ(data["picture"]["view"]["mm_per_pixel"], 0.25);
    EXPECT_EQ(data["picture"]["width"], ServerFixture::kWidth);
    EXPECT_FALSE(data["picture"].contains("h264"));
    EXPECT_TRUE(data.contains("state"));
    const double age_s =
        static_cast<double>(utc_now_ns()) / 1e9 - std::stod(data["capture_utc_ns"].get<std::string>()) / 1e9;
    EXPECT_GE(age_s, 0);
    EXPECT_LT(age_s, 60);
    EXPECT_TRUE(id == 1 || static_cast<std::int32_t>(receiver.timestamp() - last_timestamp) > 0);
    last_timestamp = receiver.timestamp();
  }
  EXPECT_GE(server.counters().rtp_pictures_sent.value(), 5U);
  EXPECT_EQ(server.counters().rtp_pictures_cut.value(), 0U);
}

TEST(RtpSender, MakesAKeyPictureWhereTheReceiverAsksForOne) {
  RtpReceiver receiver;
  ServerFixture server(sending_to(receiver));
  server.show(1, 50);
  ASSERT_TRUE(next_picture(receiver).key());
  ASSERT_TRUE(receiver.next_control());                          // so that its address is known
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // the hub makes one a second at most
  receiver.answer(picture_loss());
  // The picture does not change, so it is encoded once more.
  const Received again = next_picture(receiver);
  EXPECT_TRUE(again.key());
  EXPECT_EQ(again.data()["picture"]["picture_id"], "1");
  EXPECT_EQ(server.counters().rtp_keys_requested.value(), 1U);
}

TEST(RtpSender, MakesKeyPicturesForThoseWhoCannotAsk) {
  RtpReceiver receiver;
  ServerFixture server(sending_to(receiver));
  server.show(1, 50);
  ASSERT_TRUE(next_picture(receiver).key());
  EXPECT_TRUE(next_picture(receiver).key());
  EXPECT_EQ(server.counters().rtp_keys_requested.value(), 0U);
}

TEST(RtpSender, ReportsAndReadsReports) {
  RtpReceiver receiver;
  ServerFixture server(sending_to(receiver));
  server.show(1, 50);
  ASSERT_TRUE(next_picture(receiver).key());
  const auto report = receiver.next_control();
  ASSERT_TRUE(report);
  EXPECT_TRUE(parse_rtcp(*report, 0));
  EXPECT_EQ((*report)[1], 200);
  // About its source: an eighth is lost.
  std::vector<std::uint8_t> answer = {
      0x81, 201, 0, 7, 0, 0, 0, 9, (*report)[4], (*report)[5], (*report)[6], (*report)[7], 32, 0, 0, 1,
      0,    0,   0, 0, 0, 0, 0, 90};
  answer.insert(answer.end(), 8, 0);
  receiver.answer(answer);
  EXPECT_TRUE(soon([&] { return server.counters().rtp_reports_received.value() == 1; }));
  const json state = json::parse(talk(server, "GET", "/api/rtp").body);
  EXPECT_EQ(state["receiver"]["lost_percent"], 12.5);
  EXPECT_EQ(state["receiver"]["lost_packets"], 1);
  EXPECT_EQ(state["receiver"]["jitter_ms"], 1.0);
  receiver.answer({1, 2, 3});
  EXPECT_TRUE(soon([&] { return server.counters().rtp_feedback_refused.value() == 1; }));
  // More lost than was sent; and more duplicates than losses.
  constexpr std::size_t kLost = 13;
  std::copy_n(std::array<std::uint8_t, 3>{0, 255, 255}.begin(), 3, answer.begin() + kLost);
  receiver.answer(answer);
  EXPECT_TRUE(soon([&] { return server.counters().rtp_feedback_refused.value() == 2; }));
  std::copy_n(std::array<std::uint8_t, 3>{255, 255, 58}.begin(), 3, answer.begin() + kLost);
  receiver.answer(answer);
  EXPECT_TRUE(soon([&] { return server.counters().rtp_reports_received.value() == 2; }));
  EXPECT_EQ(json::parse(talk(server, "GET", "/api/rtp").body)["receiver"]["lost_packets"], 0);
}

TEST(RtpSender, IsStartedAndStoppedByAnAuditedWish) {
  const TemporaryFolder folder;
  RtpReceiver receiver;
  StreamServer::Config config = sending_to(receiver, false);
  config.audit_log = folder.path() / "audit.jsonl";
  config.rtp->sdp_file = folder.path() / "room.sdp";
  ServerFixture server(config);
  server.show(1, 50);
  EXPECT_FALSE(receiver.next_packet(300));  // off by default
  EXPECT_EQ(json::parse(talk(server, "GET", "/api/rtp").body)["state"], "stopped");
  EXPECT_EQ(wish(server, "stop").status, 409);
  EXPECT_EQ(wish(server, "dance").status, 400);
  EXPECT_EQ(talk(server, "DELETE", "/api/rtp").status, 405);
  EXPECT_EQ(wish(server, "start").status, 200);
  EXPECT_TRUE(next_picture(receiver).key());
  EXPECT_EQ(wish(server, "start").status, 409);
  EXPECT_TRUE(soon([&] { return std::filesystem::exists(config.rtp->sdp_file); }));
  EXPECT_EQ(std::filesystem::status(config.rtp->sdp_file).permissions() & std::filesystem::perms::others_all,
            std::filesystem::perms::none);
  const json state = json::parse(talk(server, "GET", "/api/rtp").body);
  EXPECT_EQ(state["state"], "sending");
  EXPECT_NE(state["sdp"].get<std::string>().find("sprop-parameter-sets="), std::string::npos);

  EXPECT_EQ(wish(server, "stop").status, 200);
  bool said_so = false;
  while (const auto packet = receiver.next_control(300)) said_so |= parse_rtcp(*packet, 0)->ends;
  EXPECT_TRUE(said_so);
  EXPECT_FALSE(std::filesystem::exists(config.rtp->sdp_file));
  while (receiver.next_packet(100)) {
  }
  server.show(2, 90);
  EXPECT_FALSE(receiver.next_packet(300));
  EXPECT_EQ(wish(server, "start").status, 200);  // and once more
  EXPECT_TRUE(receiver.next_packet());

  const auto lines = audited(config.audit_log, "rtp", 6);
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_TRUE(lines[1]["result"].get<std::string>().starts_with("refused: the wish is not known"))
      << lines[1];
  EXPECT_EQ(lines[2]["result"], "done");
  EXPECT_EQ(lines[2]["details"]["to"], "127.0.0.1:" + std::to_string(receiver.port()));
  EXPECT_EQ(server.counters().rtp_refusals.value(), 3U);
}

TEST(RtpSender, IsToldToDisplaysInTheRoom) {
  RtpReceiver receiver;
  ServerFixture server(sending_to(receiver, false));
  TestDisplay display(server.endpoint());
  ASSERT_TRUE(display.next(v1::ServerMessage::kHello).has_hello());
  ASSERT_EQ(wish(server, "start").status, 200);
  EXPECT_TRUE(display.next(v1::ServerMessage::kRelay).relay().sending());
  TestDisplay later(server.endpoint());
  EXPECT_TRUE(later.next(v1::ServerMessage::kRelay).relay().sending());
  ASSERT_EQ(wish(server, "stop").status, 200);
  EXPECT_FALSE(display.next(v1::ServerMessage::kRelay).relay().sending());
}

TEST(RtpSender, ContinuesWithoutAReceiverAndWhenItIsBack) {
  auto receiver = std::make_unique<RtpReceiver>();
  const std::uint16_t port = receiver->port();
  ServerFixture server(sending_to(*receiver));
  server.show(1, 50);
  ASSERT_TRUE(next_picture(*receiver).key());
  receiver->close();
  for (std::uint64_t id = 2; id < 12; ++id) {
    server.show(id, 60);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  boost::asio::io_context loop;
  RtpReceiver::Udp::socket back(loop, {boost::asio::ip::make_address("127.0.0.1"), port});
  std::vector<std::uint8_t> packet(2000);
  EXPECT_GT(back.receive(boost::asio::buffer(packet)), 12U);  // the next key picture, at the latest
}

TEST(RtpSender, EncryptsForAReceiverWithTheKey) {
  RtpReceiver receiver;
  StreamServer::Config config = sending_to(receiver);
  config.rtp->srtp_key = Bytes(kSrtpKeyBytes, 9);
  ServerFixture server(config);
  server.show(1, 50);
  const auto packet = receiver.next_packet();
  ASSERT_TRUE(packet);
  EXPECT_EQ((*packet)[1] & 0x7f, 96);
  const auto control = receiver.next_control();
  ASSERT_TRUE(control);
  auto context = SrtpContext::create(config.rtp->srtp_key);
  ASSERT_TRUE(context);
  Bytes opened = *control;
  ASSERT_TRUE((*context)->unprotect_rtcp(opened));
  EXPECT_TRUE(parse_rtcp(opened, 0));
  EXPECT_LT(opened.size(), control->size());

  // Without the key, a report about its source is not believed, and a picture may be asked for.
  std::vector<std::uint8_t> forged = {0x81, 201,       0,         7,         0,         0, 0,
                                      9,    opened[4], opened[5], opened[6], opened[7], 32};
  forged.resize(32);
  receiver.answer(forged);
  receiver.answer(picture_loss());
  EXPECT_TRUE(soon([&] { return server.counters().rtp_keys_requested.value() == 1; }));
  EXPECT_EQ(server.counters().rtp_reports_received.value(), 0U);
  EXPECT_FALSE(json::parse(talk(server, "GET", "/api/rtp").body).contains("receiver"));
}

}  // namespace rtp_sender_tests
}  // namespace fanlight::test
