// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <utility>

#include "proto/exchange/render_link.hpp"
#include "server/codec/encoder_pool.hpp"

namespace fanlight {

/// Why there is no copy where Outcome is kBusy, or copy() returns false.
inline constexpr const char* kRendererBusySentence =
    "the renderer has many requests to carry out, try again in a moment";

/// Gets copies of the volume that the main view shows, for work on other threads. The render thread copies;
/// it is given the memory. Server thread only.
class VolumeCopier {
 public:
  enum class Outcome : std::uint8_t { kCopied, kNoVolume, kNoMemory, kBusy };
  struct Copy {
    Outcome outcome = Outcome::kNoVolume;
    std::shared_ptr<Volume> volume;  ///< kCopied: the copy; else memory for the next one, or null
  };
  using Done = std::function<void(Copy copy)>;

  /// `link` must outlive this object.
  VolumeCopier(RenderLink& link, Executor executor) : link_(link), executor_(std::move(executor)) {}

  /// Orders a copy. `into`: the memory of an earlier copy, which no other thread uses until `done`; null:
  /// none. It is taken from the caller. Larger memory is allocated on a thread of `lane` where it is needed.
  /// `done` is called later, once. False, and nothing else, where too many orders wait. Where memory runs
  /// out, nothing has happened.
  bool copy(EncoderLane lane, std::shared_ptr<Volume>& into, Done done);

  /// An answer of the render thread.
  void answered(VolumeAnswer answer);

 private:
  struct Pending {
    std::uint64_t number = 0;
    EncoderLane lane = EncoderLane::kBackground;
    Done done;
  };
  void make_room(const VolumeAnswer& answer, Pending pending);

  RenderLink& link_;
  Executor executor_;
  std::uint64_t last_number_ = 0;
  std::list<Pending> pending_;
};

}  // namespace fanlight
