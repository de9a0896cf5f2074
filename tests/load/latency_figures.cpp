// SPDX-License-Identifier: Apache-2.0
// The latency that a display sees beyond the time of the passes, with a real server and renderer:
//   latency_figures PORT    of a `fanlight serve` on this machine without other clients
// Measures a moved light and a moved threshold until the first picture that shows them was read, and each
// volume from its last frame until its picture was read. Then the volumes again while a private light is
// open. A picture is read after its last byte has left the server, so each figure is an upper bound.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <thread>
#include <vector>

#include "proto/base/clock.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

class Times {
 public:
  void add(double ms) { ms_.push_back(ms); }
  double at(double share) {
    std::ranges::sort(ms_);
    return ms_.empty() ? 0 : ms_[static_cast<std::size_t>(share * static_cast<double>(ms_.size() - 1))];
  }
  std::size_t count() const { return ms_.size(); }

 private:
  std::vector<double> ms_;
};

/// The sum of the stages of a picture.
double stages_ms(const v1::Picture& picture, bool passes_2_and_3_alone) {
  double sum_ms = 0;
  for (const v1::StageTime& stage : picture.stages()) {
    const bool early = stage.name() == "prepare" || stage.name() == "upload" || stage.name() == "cast";
    if (!early || !passes_2_and_3_alone) sum_ms += stage.milliseconds();
  }
  return sum_ms;
}

double since_ms(std::int64_t then_ns) {
  return static_cast<double>(now_ns() - then_ns) / 1e6;
}

/// `beyond`: the part of each wait that is not the passes of the picture.
void print(const char* what, Times& waits, Times& beyond) {
  std::printf("%-29s %4zu   wait p50 %6.1f p99 %6.1f ms   beyond its passes p50 %6.1f p99 %6.1f ms\n", what,
              waits.count(), waits.at(0.5), waits.at(0.99), beyond.at(0.5), beyond.at(0.99));
  std::fflush(stdout);
}

/// Applies `change(number)` repeatedly, and waits each time for the first picture that shows it.
template <typename Change>
void measure_changes(TestDisplay& client, const char* what, bool light_alone, Change change) {
  constexpr int kChanges = 150;
  // Not a multiple of the time of a volume, so that the changes are spread over it.
  constexpr auto kPause = std::chrono::milliseconds(37);
  Times waits;
  Times beyond;
  for (int number = 0; number < kChanges; ++number) {
    std::this_thread::sleep_for(kPause);
    v1::ClientMessage message;
    message.mutable_scene_change()->set_request_id(static_cast<std::uint64_t>(number) + 1);
    change(*message.mutable_scene_change()->mutable_scene(), number);
    const std::int64_t sent_ns = now_ns();
    client.send(message);
    for (bool shown = false;;) {
      const v1::ServerMessage answer = client.next();
      if (answer.has_scene_reply() && answer.scene_reply().has_refused())
        throw std::runtime_error(answer.scene_reply().refused().message());
      shown |= answer.has_scene_shown() &&
               answer.scene_shown().request_id() == static_cast<std::uint64_t>(number) + 1;
      if (!shown || !answer.has_picture()) continue;
      const double wait_ms = since_ms(sent_ns);
      waits.add(wait_ms);
      beyond.add(wait_ms - stages_ms(answer.picture(), light_alone));
      break;
    }
  }
  print(what, waits, beyond);
}

void measure_volumes(TestDisplay& client, const char* what) {
  constexpr int kVolumes = 80;
  Times waits;
  Times beyond;
  Times sent;
  for (std::uint64_t last = 0; waits.count() < kVolumes;) {
    const v1::Picture picture = client.next(Body::kPicture).picture();
    // The first one may have been waiting since before the measurement began.
    if (picture.volume_id() != last && last != 0) {
      const double wait_ms = since_ms(picture.capture_time_ns());
      waits.add(wait_ms);
      beyond.add(wait_ms - stages_ms(picture, false));
      sent.add(since_ms(picture.finished_time_ns()));
    }
    last = picture.volume_id();
  }
  print(what, waits, beyond);
  std::printf("%-29s      of that, from the finished picture on, p50 %.1f p99 %.1f ms\n", "", sent.at(0.5),
              sent.at(0.99));
}

void measure(std::uint16_t port) {
  const boost::asio::ip::tcp::endpoint server(boost::asio::ip::make_address("127.0.0.1"), port);
  TestDisplay client(server);
  client.next(Body::kPicture);
  measure_volumes(client, "volume to picture");
  measure_changes(client, "light to picture", true, [](v1::Scene& scene, int number) {
    scene.mutable_light()->set_right_mm(number % 2 == 0 ? 50 : -50);
  });
  measure_changes(client, "threshold to picture", false, [](v1::Scene& scene, int number) {
    scene.mutable_detector()->set_threshold(number % 2 == 0 ? 22 : 20);
  });
  TestDisplay beside(server);
  v1::ClientMessage own;
  own.mutable_view()->mutable_scene()->mutable_light()->set_right_mm(70);
  beside.send(own);
  const v1::ViewReply reply = beside.next(Body::kViewReply).view_reply();
  if (reply.has_refused()) {
    std::printf("a private light beside: refused, %s\n", reply.refused().message().c_str());
    return;
  }
  int private_pictures = 0;
  std::jthread reader([&](const std::stop_token& stop) {
    while (!stop.stop_requested())
      private_pictures += beside.next(Body::kPicture).picture().private_view() ? 1 : 0;
  });
  measure_volumes(client, "volume, private light beside");
  reader.request_stop();
  reader.join();
  std::printf("pictures of the private view meanwhile: %d\n", private_pictures);
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  std::uint16_t port = 0;
  const std::string_view text = argc == 2 ? argv[1] : "";
  if (std::from_chars(text.data(), text.data() + text.size(), port).ec != std::errc{} || port == 0) {
    std::fprintf(stderr, "latency_figures: expected the port of a server on this machine\n");
    return 2;
  }
  try {
    fanlight::test::measure(port);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "latency_figures: %s\n", error.what());
    return 1;
  }
}
