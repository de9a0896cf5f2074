// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef FANLIGHT_CHECK_THREADS
#include <atomic>
#endif

namespace fanlight {

/// Checks that one thread uses an object. A member of classes whose documentation names their thread; their
/// functions call check(). In builds with sanitizers, and in the preset dev, a call on another thread than
/// the first one ends the process with a sentence. In other builds this is empty.
class ThreadOwner {
 public:
  ThreadOwner() = default;
#ifdef FANLIGHT_CHECK_THREADS
  // A moved object may belong to another thread.
  ThreadOwner(const ThreadOwner& /*other*/) noexcept {}
  ThreadOwner& operator=(const ThreadOwner& /*other*/) noexcept {
    release();
    return *this;
  }

  /// The first call, or the first after release(), makes the calling thread the owner.
  void check() const;
  /// The object is passed to another thread. Any thread; it must happen before that one's first call.
  void release() const {
    owner_.store(nullptr, std::memory_order_relaxed);
  }

 private:
  mutable std::atomic<const void*> owner_ = nullptr;  // address of a variable of the owner thread
#else
  void check() const {}
  void release() const {}
#endif
};

}  // namespace fanlight
