// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "proto/exchange/doorbell.hpp"

namespace fanlight {

/// Whether anybody needs pictures. Written by the server thread, read by the render thread. Present at first.
class Audience {
 public:
  /// `bell`: of the render thread; must outlive this object. Rings when an audience comes.
  explicit Audience(Doorbell& bell) : bell_(bell) {}

  void set_present(bool present) {
    const bool before = present_.exchange(present, std::memory_order_release);
    if (!present || before) return;
    arrivals_.fetch_add(1, std::memory_order_release);
    bell_.ring();
  }
  bool present() const { return present_.load(std::memory_order_acquire); }

  /// How often an audience has come. A reader that was asleep sees by it that one had left meanwhile.
  std::uint64_t arrivals() const { return arrivals_.load(std::memory_order_acquire); }

 private:
  std::atomic<bool> present_ = true;
  std::atomic<std::uint64_t> arrivals_ = 0;
  Doorbell& bell_;
};

}  // namespace fanlight
