// How long a display waits, from sending a moved light to having the first picture that shows it, while the
// server streams.
//   light_latency PORT    of a server on this machine
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <string_view>
#include <thread>
#include <vector>

#include "proto/clock.hpp"
#include "tests/support/stream_client.hpp"

namespace fanlight::test {
namespace {

/// Milliseconds from sending the change to the arrival of a picture of it.
double light_to_picture_ms(StreamClient& client, double right_mm) {
  v1::ClientMessage message;
  message.mutable_scene_change()->mutable_scene()->mutable_light()->set_right_mm(right_mm);
  const std::int64_t sent_ns = now_ns();
  client.send(message);
  std::uint64_t revision = 0;
  for (;;) {
    const auto answer = client.next();
    if (answer.has_scene_reply()) revision = answer.scene_reply().in_force().revision();
    const bool shows_it =
        answer.has_picture() && revision > 0 && answer.picture().scene_revision() >= revision;
    if (shows_it) return static_cast<double>(now_ns() - sent_ns) / 1e6;
  }
}

void measure(std::uint16_t port) {
  constexpr int kMoves = 60;
  // No multiple of a volume's time, so that the moves fall anywhere in it.
  constexpr auto kPause = std::chrono::milliseconds(137);
  StreamClient client({boost::asio::ip::make_address("127.0.0.1"), port});
  client.next(v1::ServerMessage::kPicture);
  std::vector<double> waits_ms;
  for (int move = 0; move < kMoves; ++move) {
    std::this_thread::sleep_for(kPause);
    waits_ms.push_back(light_to_picture_ms(client, move % 2 == 0 ? 50 + move : -50 - move));
  }
  std::ranges::sort(waits_ms);
  std::printf("light to picture, %d moves: p50 %.0f ms, p90 %.0f ms, longest %.0f ms\n", kMoves,
              waits_ms[kMoves / 2], waits_ms[kMoves * 9 / 10], waits_ms.back());
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  std::uint16_t port = 0;
  const std::string_view text = argc == 2 ? argv[1] : "";
  if (std::from_chars(text.data(), text.data() + text.size(), port).ec != std::errc{}) {
    std::fprintf(stderr, "light_latency: expected the port of a server on this machine\n");
    return 2;
  }
  try {
    fanlight::test::measure(port);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "light_latency: %s\n", error.what());
    return 1;
  }
}
