// SPDX-License-Identifier: Apache-2.0
#include "server/service/loop_executor.hpp"

#include <boost/asio/post.hpp>
#include <chrono>
#include <memory>
#include <new>
#include <thread>
#include <utility>

namespace fanlight {

namespace {

void post(boost::asio::io_context& loop, const std::shared_ptr<std::function<void()>>& done) {
  while (!loop.stopped()) {
    try {
      return boost::asio::post(loop, [done] {
        // What it holds, such as a session, ends here, though the encoder's thread may still hold `done`.
        const auto run = std::exchange(*done, nullptr);
        run();
      });
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
}

}  // namespace

void LoopExecutor::run(EncoderLane lane, std::function<void()> work, std::function<void()> done) {
  // Shared, so that nothing is lost where it cannot be handed over at once.
  const auto kept = std::make_shared<std::function<void()>>(std::move(done));
  encoders_.submit(lane, [this, work = std::move(work), kept] {
    work();
    post(loop_, kept);
  });
}

}  // namespace fanlight
