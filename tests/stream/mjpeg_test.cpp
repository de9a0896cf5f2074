// SPDX-License-Identifier: Apache-2.0
// Motion JPEG for an <img>: who leaves, who is too slow, and the words in the pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <functional>
#include <thread>

#include "server/api/api_query.hpp"
#include "server/codec/picture_coder.hpp"
#include "server/codec/picture_mark.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

/// A viewer, as a browser is one.
class Viewer {
 public:
  explicit Viewer(const ServerFixture& fixture, const std::string& query = "") : socket_(loop_) {
    socket_.connect(fixture.endpoint());
    boost::asio::write(socket_, boost::asio::buffer("GET /api/stream.mjpeg" + query +
                                                    " HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  }
  /// What comes up to this text, without it.
  std::string until(const std::string& end) {
    const std::size_t bytes = boost::asio::read_until(socket_, incoming_, end);
    const auto data = incoming_.data();
    std::string text(boost::asio::buffers_begin(data),
                     boost::asio::buffers_begin(data) + std::ptrdiff_t(bytes));
    incoming_.consume(bytes);
    return text.substr(0, text.size() - end.size());
  }
  void close() { socket_.close(); }
  boost::asio::ip::tcp::socket& socket() { return socket_; }

 private:
  boost::asio::io_context loop_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::streambuf incoming_;
};

bool within_seconds(int seconds, const std::function<bool()>& holds) {
  for (int i = 0; i < seconds * 100 && !holds(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return holds();
}

TEST(Mjpeg, SendsEachPictureAndCountsThem) {
  ServerFixture fixture;
  Viewer viewer(fixture);
  const std::string head = viewer.until("\r\n\r\n");
  EXPECT_TRUE(head.starts_with("HTTP/1.1 200")) << head;
  EXPECT_NE(head.find("multipart/x-mixed-replace; boundary=fanlight-picture"), std::string::npos);
  EXPECT_NE(head.find("no-store"), std::string::npos);
  for (const std::uint64_t id : {5, 6}) {
    fixture.show(id, 99);
    std::string part;
    do {  // the words may change, and the picture comes once more
      part = viewer.until("\r\n--fanlight-picture\r\n");
    } while (part.find("X-Fanlight-Picture-Id: " + std::to_string(id)) == std::string::npos);
    EXPECT_NE(part.find("\r\n\r\n\xFF\xD8"), std::string::npos) << "a JPEG follows the header";
  }
  const ServerCounters& counters = fixture.counters();
  EXPECT_EQ(counters.sessions_opened.value(), 1U);
  viewer.close();
  EXPECT_TRUE(within_seconds(5, [&] { return counters.sessions_closed.value() == 1; }));
  EXPECT_EQ(counters.pictures_offered.value(),
            counters.pictures_sent.value() + counters.pictures_skipped.value());
}

TEST(Mjpeg, AViewerThatReadsNothingIsDroppedAndHurtsNobody) {
  StreamServer::Config config;
  config.session_limits.stalled_s = 1;
  ServerFixture fixture(config, "running", ServerFixture::kNoiseSize);
  Viewer mute(fixture, "?quality=100");
  mute.socket().set_option(boost::asio::socket_base::receive_buffer_size(4096));
  TestDisplay display(fixture.endpoint());
  display.next(v1::ServerMessage::kHello);
  std::uint64_t id = 0;
  const bool dropped = within_seconds(20, [&] {
    fixture.show_noise(++id);
    display.next(v1::ServerMessage::kPicture);
    return fixture.counters().sessions_stalled.value() == 1;
  });
  EXPECT_TRUE(dropped);
  EXPECT_EQ(fixture.counters().sessions_closed.value(), 1U);
  fixture.show_noise(++id);
  display.next(v1::ServerMessage::kPicture);
}

TEST(PictureMark, IsWrittenIntoACopyAndFitsAnySize) {
  for (const PictureSize size : {PictureSize{512, 512}, PictureSize{64, 64}, PictureSize{16, 16}}) {
    const std::vector<std::uint8_t> grey(std::size_t{4} * size.pixels(), 100);
    const Pixels pixels{.width = size.width, .height = size.height, .rgba = grey};
    PictureMarker marker;
    EXPECT_EQ(marker.marked(pixels, PictureMark::kNone).rgba.data(), grey.data()) << "no copy";
    for (const PictureMark mark : {PictureMark::kNotLive, PictureMark::kDelayed, PictureMark::kFrozen,
                                   PictureMark::kReplay, PictureMark::kSimulated}) {
      const Pixels marked = marker.marked(pixels, mark);
      ASSERT_EQ(marked.rgba.size(), grey.size());
      const auto changed =
          std::ranges::count_if(marked.rgba, [](std::uint8_t value) { return value != 100; });
      EXPECT_GT(changed, 0) << mark_words(mark);
      EXPECT_LT(changed, static_cast<std::ptrdiff_t>(grey.size() / 3))
          << mark_words(mark) << " " << size.width;
      EXPECT_EQ(marked.rgba.back(), 100);
    }
  }
}

TEST(ApiQuery, TakesKnownParametersOnce) {
  static constexpr QueryParameter kKnown[] = {{.name = "size"}, {.name = "quality"}, {.name = "rate"}};
  const auto query = parse_query("/api/picture.jpg?size=320x200&quality=7&rate=2.5", kKnown);
  ASSERT_TRUE(query);
  const auto settings = jpeg_settings(*query, 85);
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->most_width, 320U);
  EXPECT_EQ(settings->most_height, 200U);
  EXPECT_EQ(settings->quality, 7);
  EXPECT_EQ(settings->rate_hz, 2.5);
  EXPECT_EQ(jpeg_settings({}, 85)->quality, 85);
  for (const char* wrong : {"/?none=1", "/?size=1&size=1", "/?SIZE=1", "/?%73ize", "no path"}) {
    const auto parsed = parse_query(wrong, kKnown);
    EXPECT_TRUE(!parsed || !jpeg_settings(*parsed, 85)) << wrong;
  }
  for (const char* wrong : {"nan", "-1", "0", "1e400", "101", "7 ", "7x", "7.5", ""})
    EXPECT_FALSE(jpeg_settings({{"quality", wrong}}, 85)) << wrong;
}

}  // namespace
}  // namespace fanlight::test
