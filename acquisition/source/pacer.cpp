// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/pacer.hpp"

#include "proto/base/clock.hpp"

namespace fanlight {

bool Pacer::wait_until(std::int64_t due_ns, const std::stop_token& stop) {
  const std::stop_callback wake(stop, [this] { bell_.ring(); });
  while (!stop.stop_requested()) {
    const std::int64_t remaining_ns = due_ns - now_ns();
    if (remaining_ns <= 0) return true;
    bell_.wait(remaining_ns);
  }
  return false;
}

}  // namespace fanlight
