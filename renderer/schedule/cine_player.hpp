// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "proto/exchange/cine.hpp"

namespace fanlight {

/// Which of the kept volumes is on show, and until when. Knows their capture times alone; the time is a
/// parameter. Render thread only.
class CinePlayer {
 public:
  /// `capacity`: most volumes that freeze() is given; allocates for them.
  explicit CinePlayer(std::uint32_t capacity) { capture_times_ns_.reserve(capacity); }

  /// The capture times of the volumes to be kept, oldest first; empty while live. Fill it before freeze().
  std::vector<std::int64_t>& capture_times_ns() { return capture_times_ns_; }

  /// Shows the newest volume, paused. Precondition: there is one.
  void freeze();
  /// Pauses at a volume; beyond the newest: at the newest. Precondition: is_frozen().
  void seek(std::uint32_t volume);
  /// Forgets the volumes; the speed stays.
  void go_live();

  /// Carries out the orders but for kFreeze and kLive. Without an effect while live.
  void obey(const CineOrder& order, std::int64_t now_ns);

  /// Brings the volume on show up to date; call it before volume() and status().
  void advance(std::int64_t now_ns);

  bool is_frozen() const { return frozen_; }
  std::uint32_t volume() const { return volume_; }

  /// When advance() changes the volume; absent where it does not.
  std::optional<std::int64_t> next_change_ns() const;

  /// `capacity` is left to the caller.
  CineStatus status() const;

 private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(capture_times_ns_.size()); }
  std::int64_t shown_for_ns() const;

  std::vector<std::int64_t> capture_times_ns_;
  bool frozen_ = false;
  bool playing_ = false;
  std::uint32_t volume_ = 0;
  std::int64_t shown_since_ns_ = 0;
  double speed_ = 1;
};

}  // namespace fanlight
