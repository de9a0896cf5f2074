// SPDX-License-Identifier: Apache-2.0
// Many displays in one process. They read all pictures and record their age:
//   viewers --port 8080 --viewers 50 --seconds 10
// Prints a line of JSON at the end. --idle: the same number of silent connections instead, reopened when
// closed.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;

class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(asio::io_context& loop, const tcp::endpoint& server) : socket_(loop), server_(server) {}

  /// `png_side`: asks for PNG with the depth map, of at most this many pixels a side; 0: what the server
  /// chooses.
  void start(std::uint32_t png_side) {
    beast::get_lowest_layer(socket_).connect(server_);
    socket_.read_message_max(16 << 20);
    socket_.handshake("127.0.0.1", "/stream");
    if (png_side > 0) {
      v1::ClientMessage request;
      request.mutable_stream()->set_codec(v1::StreamRequest::PNG);
      request.mutable_stream()->set_with_depth(true);
      request.mutable_stream()->set_width(png_side);
      request.mutable_stream()->set_height(png_side);
      socket_.binary(true);
      socket_.write(asio::buffer(request.SerializeAsString()));
    }
    read();
  }

  std::uint64_t pictures() const { return pictures_; }
  const std::vector<double>& ages_ms() const { return ages_ms_; }
  const v1::Statistics& statistics() const { return statistics_; }
  bool lost() const { return lost_; }

 private:
  void read() {
    socket_.async_read(incoming_,
                       [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                         self->lost_ = bool(failure);
                         if (failure) return;
                         self->take();
                         self->incoming_.clear();
                         self->read();
                       });
  }

  void take() {
    const std::int64_t now = now_ns();
    v1::ServerMessage message;
    if (!message.ParseFromArray(incoming_.cdata().data(), static_cast<int>(incoming_.size()))) return;
    if (message.has_picture()) {
      ++pictures_;
      ages_ms_.push_back(static_cast<double>(now - message.picture().finished_time_ns()) / 1e6);
    } else if (message.has_statistics()) {
      statistics_ = message.statistics();
    }
  }

  beast::websocket::stream<beast::tcp_stream> socket_;
  tcp::endpoint server_;
  beast::flat_buffer incoming_;
  std::uint64_t pictures_ = 0;
  std::vector<double> ages_ms_;
  v1::Statistics statistics_;
  bool lost_ = false;
};

/// Silent connections. Closed ones are reopened.
class Idlers {
 public:
  Idlers(asio::io_context& loop, tcp::endpoint server, int count) : loop_(loop), server_(std::move(server)) {
    for (int one = 0; one < count; ++one) open();
  }
  std::uint64_t opened() const { return opened_; }

 private:
  void open() {
    auto socket = std::make_shared<tcp::socket>(loop_);
    socket->async_connect(server_, [this, socket](beast::error_code failure) {
      if (failure) return;
      ++opened_;
      socket->async_wait(tcp::socket::wait_read, [this, socket](beast::error_code) { open(); });
    });
  }
  asio::io_context& loop_;
  tcp::endpoint server_;
  std::uint64_t opened_ = 0;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

int run(int argc, char** argv) {
  CLI::App program("Many displays of a Fanlight server");
  std::uint16_t port = 8080;
  int viewers = 1;
  bool png = false;
  int idle = 0;
  double seconds = 10;
  program.add_option("--port", port);
  program.add_option("--viewers", viewers);
  program.add_option("--idle", idle);
  program.add_flag("--png", png, "PNG with depth, each viewer in a size of its own");
  program.add_option("--seconds", seconds);
  CLI11_PARSE(program, argc, argv);
  asio::io_context loop;
  const tcp::endpoint server(asio::ip::make_address("127.0.0.1"), port);
  std::vector<std::shared_ptr<Viewer>> all;
  for (int one = 0; one < viewers; ++one) all.push_back(std::make_shared<Viewer>(loop, server));
  std::uint32_t png_side = png ? 256 : 0;  // of the first viewer; each further one asks for four more
  for (const auto& viewer : all) {
    viewer->start(png_side);
    png_side += png ? 4 : 0;
  }
  const Idlers idlers(loop, server, idle);
  std::puts("ready");
  std::fflush(stdout);
  loop.run_for(std::chrono::milliseconds(static_cast<int>(seconds * 1000)));
  std::vector<double> ages_ms;
  std::uint64_t fewest = ~0ULL;
  bool exact = true;
  int lost = 0;
  for (const auto& viewer : all) {
    ages_ms.insert(ages_ms.end(), viewer->ages_ms().begin(), viewer->ages_ms().end());
    fewest = std::min(fewest, viewer->pictures());
    lost += viewer->lost() ? 1 : 0;
    // At most one picture waits and one is being sent.
    const v1::Statistics& counts = viewer->statistics();
    const std::uint64_t done = counts.pictures_sent() + counts.pictures_skipped();
    exact &= counts.pictures_offered() >= done && counts.pictures_offered() <= done + 2;
  }
  std::printf("%s\n",
              nlohmann::json({{"viewers", viewers},
                              {"fewest_pictures", viewers > 0 ? fewest : 0},
                              {"fewest_a_second", viewers > 0 ? static_cast<double>(fewest) / seconds : 0},
                              {"age_p50_ms", quantile(ages_ms, 0.5)},
                              {"age_p99_ms", quantile(ages_ms, 0.99)},
                              {"lost", lost},
                              {"accounts_exact", exact},
                              {"idle_opened", idlers.opened()}})
                  .dump()
                  .c_str());
  return 0;
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  try {
    return fanlight::test::run(argc, argv);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "viewers: %s\n", failure.what());
    return 1;
  }
}
