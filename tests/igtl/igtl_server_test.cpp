// SPDX-License-Identifier: Apache-2.0
// The OpenIGTLink server, by a client of its own.
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "proto/base/crc64.hpp"
#include "proto/igtl/image_body.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "tests/igtl/corpus.hpp"
#include "tests/igtl/igtl_server_rig.hpp"

namespace fanlight::test {
namespace igtl_server_tests {

std::string carried_out(TestClient& client, const std::string& name, const std::string& xml,
                        std::uint32_t id = 7) {
  igtl::put_command(
      client.writer().begin({.type = "COMMAND", .device = "x", .version = igtl::HeadVersion::kTwo}),
      {.id = id, .name = FixedText<128>(std::string_view(name)), .text = xml});
  EXPECT_TRUE(client.send(client.writer().finish()));
  const auto reply = client.next_of("RTS_COMMAND");
  if (!reply) return "no reply";
  const auto command = igtl::parse_command(reply->opened().content);
  if (!command) return "no command";
  EXPECT_EQ(command->id, id);
  EXPECT_EQ(command->name.view(), name);
  return std::string(command->text);
}

TEST(IgtlServer, SendsPicturesToAClientThatAsksForNothing) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  const auto status = client.next_of("STATUS");
  ASSERT_TRUE(status);
  EXPECT_EQ(igtl::parse_status(status->opened().content)->code, igtl::StatusCode::kNotReady);
  server.show(1, 90);
  const auto picture = client.next_of("IMAGE");
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->head.version, 1U);
  EXPECT_EQ(picture->device(), "Picture_Transducer");
  const auto image = igtl::parse_image(picture->opened().content);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->body.size[0], ServerFixture::kWidth);
  EXPECT_EQ(image->pixels[0], 90);
  EXPECT_TRUE(client.next_of("TRANSFORM", "CameraToTransducer"));
}

TEST(IgtlServer, SendsWhatIsAskedForAndNothingElse) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STT_IMAGE", "Depth_Transducer", igtl::HeadVersion::kTwo));
  const auto answer = client.next_of("RTS_IMAGE");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->device(), "Depth_Transducer");
  EXPECT_EQ(answer->opened().content[0], 0);
  for (std::uint64_t id = 1; id < 4; ++id) {
    server.show_depths(id, [](std::uint32_t, std::uint32_t) { return 12.5F; });
    const auto message = client.next_of("IMAGE");
    ASSERT_TRUE(message);
    EXPECT_EQ(message->device(), "Depth_Transducer");
    EXPECT_EQ(message->head.version, 2U);
    EXPECT_EQ(message->opened().metadata.find("FanlightPicture"), std::to_string(id));
  }
  ASSERT_TRUE(client.ask("STP_IMAGE", ""));
  ASSERT_TRUE(client.next_of("RTS_IMAGE"));
  server.show(9, 1);
  while (const auto message = client.next(300)) EXPECT_NE(message->type(), "IMAGE");
  EXPECT_EQ(server.counters().igtl_messages_offered.value(), 3U);
  EXPECT_EQ(server.counters().igtl_messages_sent.value(), 3U);
}

TEST(IgtlServer, AnswersQueriesForOneMessage) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STP_IMAGE", ""));
  ASSERT_TRUE(client.ask("STP_TRANS", ""));
  ASSERT_TRUE(client.next_of("RTS_TRANS"));
  server.show_depths(1, [](std::uint32_t, std::uint32_t) { return 5.0F; });
  ASSERT_TRUE(client.ask("GET_POLYDATA", ""));
  EXPECT_TRUE(client.next_of("POLYDATA", "Surface_Transducer"));
  ASSERT_TRUE(client.ask("GET_TRANS", "CameraToTransducer"));
  EXPECT_TRUE(client.next_of("TRANSFORM"));
  ASSERT_TRUE(client.ask("GET_CAPABIL", ""));
  const auto capability = client.next_of("CAPABILITY");
  ASSERT_TRUE(capability);
  EXPECT_GT(igtl::parse_capability(capability->opened().content).size(), 10U);
  ASSERT_TRUE(client.ask("GET_STATUS", ""));
  EXPECT_TRUE(client.next_of("STATUS"));
  ASSERT_TRUE(client.ask("GET_POINT", "Somewhere"));
  const auto none = client.next_of("POINT");
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->opened().content.empty()) << "not available: a message without a body";
  ASSERT_TRUE(client.ask("STT_QTDATA", ""));
  const auto refused = client.next_of("RTS_QTDATA");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->opened().content[0], 1);
}

TEST(IgtlServer, SendsAPictureOnceToEachClient) {
  ServerFixture server(with_igtl());
  TestClient first(server.igtl_port());
  server.show(1, 90);
  ASSERT_TRUE(first.next_of("TRANSFORM"));
  TestClient second(server.igtl_port());
  ASSERT_TRUE(second.next_of("TRANSFORM")) << "who comes later gets the newest picture";
  ASSERT_TRUE(second.ask("GET_TRANS", ""));
  ASSERT_TRUE(second.next_of("TRANSFORM")) << "and again where it asks";
  while (const auto message = first.next(300)) EXPECT_NE(message->type(), "TRANSFORM") << "the others do not";
}

TEST(IgtlServer, ReadsNoMoreOfAClientThanItsShareOfASecond) {
  ServerFixture server(with_igtl(Role::kOperator, 20));
  TestClient client(server.igtl_port());
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(client.ask("POINT", ""));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_LE(server.counters().igtl_messages_ignored.value(), 40U);
  EXPECT_TRUE(soon([&] { return server.counters().igtl_messages_ignored.value() == 60; }))
      << "the rest later";
}

TEST(IgtlServer, CarriesOutCommands) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  const std::string all = carried_out(client, "GetParameter", "<Command Name=\"GetParameter\"/>");
  EXPECT_NE(all.find("Name=\"light.up_mm\""), std::string::npos);
  EXPECT_NE(all.find("Status=\"SUCCESS\""), std::string::npos);
  const std::string set =
      carried_out(client, "SetParameter",
                  "<Command Name=\"SetParameter\"><Parameter Name=\"light.up_mm\" Value=\"20\"/>"
                  "<Parameter Name=\"mode\" Value=\"mip\"/></Command>");
  EXPECT_NE(set.find("Status=\"FAIL\""), std::string::npos) << set;
  EXPECT_NE(set.find("maximum"), std::string::npos) << "it names what there is";
  EXPECT_EQ(carried_out(client, "GetParameter", "<Command Name=\"GetParameter\"/>")
                .find("Name=\"light.up_mm\" Value=\"20\""),
            std::string::npos)
      << "one wrong field, and nothing is done";
  EXPECT_NE(
      carried_out(client, "SetParameter",
                  "<Command Name=\"SetParameter\"><Parameter Name=\"light.up_mm\" Value=\"20\"/></Command>")
          .find("Value=\"20\""),
      std::string::npos);
  EXPECT_NE(
      carried_out(client, "SetParameter",
                  "<Command Name=\"SetParameter\"><Parameter Name=\"light.up_mm\" Value=\"1e9\"/></Command>")
          .find("Status=\"FAIL\""),
      std::string::npos);
  for (const char* const command : {"GetParameter", "SetParameter"}) {
    const std::string misspelt =
        fmt::format("<Command Name=\"{}\"><Parameter Name=\"light.upp_mm\" Value=\"1\"/></Command>", command);
    EXPECT_NE(carried_out(client, command, misspelt).find("did you mean light.up_mm?"), std::string::npos);
  }
  EXPECT_NE(carried_out(client, "Reboot", "<Command Name=\"Reboot\"/>").find("there is no command Reboot"),
            std::string::npos);
  EXPECT_NE(carried_out(client, "SetParameter", "light=20").find("no XML"), std::string::npos);
  EXPECT_GE(server.counters().igtl_command_refusals.value(), 3U);
  EXPECT_GE(server.counters().scene_changes.value(), 1U);
}

TEST(IgtlServer, LetsAViewerChangeNothing) {
  ServerFixture server(with_igtl(Role::kViewer));
  TestClient client(server.igtl_port());
  const std::string reply =
      carried_out(client, "SetParameter",
                  "<Command Name=\"SetParameter\"><Parameter Name=\"light.up_mm\" Value=\"20\"/></Command>");
  EXPECT_NE(reply.find("Status=\"FAIL\""), std::string::npos) << reply;
  EXPECT_EQ(server.counters().scene_changes.value(), 0U);
  EXPECT_NE(carried_out(client, "GetParameter", "<Command Name=\"GetParameter\"/>").find("SUCCESS"),
            std::string::npos);
}

TEST(IgtlServer, TakesCommandsAsTextsOnce) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  const auto send = [&](const char* device) {
    igtl::put_string(
        client.writer().begin({.type = "STRING", .device = device}),
        "<Command Name=\"SetParameter\"><Parameter Name=\"light.up_mm\" Value=\"20\"/></Command>");
    EXPECT_TRUE(client.send(client.writer().finish()));
  };
  send("CMD_12");
  const auto reply = client.next_of("STRING");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->device(), "ACK_12");
  EXPECT_NE(igtl::parse_string(reply->opened().content)->find("SUCCESS"), std::string::npos);
  send("CMD_12");
  send("CMD_13");
  const auto next = client.next_of("STRING");
  ASSERT_TRUE(next);
  EXPECT_EQ(next->device(), "ACK_13") << "a repetition is not carried out again";
}

TEST(IgtlServer, DropsAClientThatTakesNothing) {
  ServerFixture server(with_igtl(), "running", ServerFixture::kSurfaceSize);
  TestClient slow(server.igtl_port(), 4096);
  TestClient quick(server.igtl_port());
  std::uint64_t id = 1;
  const auto begun = std::chrono::steady_clock::now();
  while (server.counters().igtl_clients_stalled.value() == 0 &&
         std::chrono::steady_clock::now() - begun < std::chrono::seconds(20)) {
    server.show_surface(id++);
    EXPECT_TRUE(quick.next_of("IMAGE"));
  }
  EXPECT_EQ(server.counters().igtl_clients_stalled.value(), 1U);
  const ServerCounters& counters = server.counters();
  EXPECT_TRUE(soon([&] { return counters.igtl_clients_closed.value() == 1; }));
  EXPECT_GT(counters.igtl_messages_skipped.value(), 0U);
  EXPECT_TRUE(soon([&] {
    return counters.igtl_messages_offered.value() ==
           counters.igtl_messages_sent.value() + counters.igtl_messages_skipped.value();
  }));
}

TEST(IgtlServer, SkipsImagesAndDisconnectsWhatIsNoOpenIgtlink) {
  ServerFixture server(with_igtl());
  TestClient imager(server.igtl_port());
  igtl::ImageBody image;
  image.size = image.part_size = {500, 400, 1};
  auto& bytes = imager.writer().begin({.type = "IMAGE", .device = "Imager"});
  igtl::put_image_header(bytes, image);
  bytes.resize(bytes.size() + image.part_bytes());
  ASSERT_TRUE(imager.send(imager.writer().finish()));
  ASSERT_TRUE(imager.ask("GET_STATUS", ""));
  ASSERT_TRUE(imager.next_of("STATUS"));
  EXPECT_TRUE(imager.next_of("STATUS"));
  EXPECT_EQ(server.counters().igtl_messages_ignored.value(), 1U);
  TestClient browser(server.igtl_port());
  const std::string request =
      "GET / HTTP/1.1\r\nHost: here\r\nUser-Agent: a browser that has lost its way\r\n\r\n";
  ASSERT_TRUE(browser.send(std::vector<std::uint8_t>(request.begin(), request.end())));
  while (browser.next(2000)) {
  }
  EXPECT_TRUE(browser.closed());
  EXPECT_EQ(server.counters().igtl_messages_refused.value(), 1U);
}

void expect_same(const std::optional<GotMessage>& message, const std::string& name) {
  SCOPED_TRACE(name);
  ASSERT_TRUE(message);
  std::vector<std::uint8_t> bytes = corpus_message(name);
  igtl::MessageHead head = *igtl::parse_head(std::span(bytes).first<igtl::kHeadBytes>());
  bytes.erase(bytes.begin(), bytes.begin() + igtl::kHeadBytes);
  EXPECT_EQ(message->type(), head.type.view());
  EXPECT_EQ(message->device(), head.device.view());
  EXPECT_EQ(message->head.crc, head.crc);
  EXPECT_EQ(message->body, bytes);
}

TEST(IgtlServer, AnswersTheCorpusByTheCorpus) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.send(corpus_message("start_of_image")));
  expect_same(client.next_of("RTS_IMAGE"), "reply_to_start_of_image");
  ASSERT_TRUE(client.send(corpus_message("stop_of_image")));
  expect_same(client.next_of("RTS_IMAGE"), "reply_to_start_of_image");
  ASSERT_TRUE(client.send(corpus_message("start_of_other_video")));
  expect_same(client.next_of("RTS_VIDEO"), "refusal_of_video");
  ASSERT_TRUE(client.send(corpus_message("start_of_video")));
  expect_same(client.next_of("RTS_VIDEO"), "reply_to_start_of_video");
  ASSERT_TRUE(client.send(corpus_message("start_of_unknown")));
  expect_same(client.next_of("RTS_QTDATA"), "refusal_of_unknown");
  ASSERT_TRUE(client.send(corpus_message("start_of_image_version_2")));
  const auto reply = client.next_of("RTS_IMAGE");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->head.version, 2);
  EXPECT_EQ(reply->opened().content[0], 0);
  ASSERT_TRUE(client.send(corpus_message("command")));
  const auto done = client.next_of("RTS_COMMAND");
  ASSERT_TRUE(done);
  EXPECT_EQ(igtl::parse_command(done->opened().content)->id, 9U);
}

// The versions, the lengths and the signs of the types hold, so that the connection lasts; everything else
// may be wrong.
TEST(IgtlServer, Stands100000MutatedMessages) {
  ServerFixture server(with_igtl(Role::kOperator, 1'000'000));
  server.show(1, 90);
  TestClient client(server.igtl_port());
  std::mt19937 random(5);
  std::vector<std::vector<std::uint8_t>> originals = corpus_messages();
  std::erase_if(originals, [](const auto& message) {
    const auto head = igtl::parse_head(std::span(message).template first<igtl::kHeadBytes>());
    return !head || head->body_bytes != message.size() - igtl::kHeadBytes;
  });
  ASSERT_GE(originals.size(), 30U);
  std::jthread reader([&client](const std::stop_token& stop) {
    while (!stop.stop_requested()) (void)client.next(50);
  });
  constexpr std::size_t kDeviceBegins = 14;
  constexpr std::size_t kLengthBegins = 42;
  std::vector<std::uint8_t> batch;
  for (int i = 0; i < 100'000; ++i) {
    std::vector<std::uint8_t> message = originals[random() % originals.size()];
    for (std::uint32_t changes = random() % 4; changes > 0; --changes) {
      const std::size_t at = 2 + random() % (message.size() - 2);
      const bool is_length = at >= kLengthBegins && at < kLengthBegins + 8;
      if (at < kDeviceBegins)
        message[2] = static_cast<std::uint8_t>('A' + random() % 26);
      else if (!is_length)
        message[at] = static_cast<std::uint8_t>(random());
    }
    if (random() % 3 != 0) {
      const std::uint64_t crc = crc64(std::span(message).subspan(igtl::kHeadBytes));
      for (std::size_t byte = 0; byte < 8; ++byte)
        message[50 + byte] = static_cast<std::uint8_t>(crc >> (56 - 8 * byte));
    }
    batch.insert(batch.end(), message.begin(), message.end());
    if (batch.size() < 100'000 && i < 99'999) continue;
    ASSERT_TRUE(client.send(batch)) << "the connection lasts";
    batch.clear();
  }
  reader.request_stop();
  reader.join();
  TestClient other(server.igtl_port());
  EXPECT_TRUE(other.next_of("STATUS")) << "the server continues";
  EXPECT_TRUE(soon([&] { return server.counters().igtl_messages_refused.value() > 1000; }));
  EXPECT_GT(server.counters().igtl_messages_ignored.value(), 1000U);
}

TEST(IgtlServer, SaysThatItEnds) {
  auto server = std::make_unique<ServerFixture>(with_igtl());
  TestClient client(server->igtl_port());
  ASSERT_TRUE(client.next_of("STATUS"));
  EXPECT_EQ(server->counters().igtl_clients_opened.value(), 1U);
  server.reset();
  while (client.next(2000)) {
  }
  EXPECT_TRUE(client.closed());
}

}  // namespace igtl_server_tests
}  // namespace fanlight::test
