// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/base/thread_owner.hpp"
#include "proto/exchange/cine.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "renderer/schedule/cine_player.hpp"

namespace fanlight {

/// The cine on the render thread: keeps the ring's last volumes while the display is frozen, and says which
/// of them is due. Nothing is copied: the ring does not overwrite what is kept. Allocates in the constructor
/// only.
class Cine {
 public:
  /// `ring` must outlive this object.
  explicit Cine(VolumeRing& ring) : ring_(ring), player_(ring.most_kept() + 1) {}

  /// Updates the volume on show; call it before the others. `shown`: the newest volume, which its lease
  /// keeps; null before the first one.
  void advance(const Volume* shown, std::int64_t now_ns);

  /// Carries out an order. True where the newest volume must be loaded again, because an older one is on
  /// show.
  bool obey(const CineOrder& order, const Volume* shown, std::int64_t now_ns);

  CineStatus status() const;

  bool is_frozen() const { return player_.is_frozen(); }

  /// The kept volume to load: another one than was loaded last. Null where there is none, or while live.
  const Volume* due() const;
  /// The kept volume that was loaded last; null while live.
  const Volume* on_show() const { return is_frozen() && loaded_ ? volume(*loaded_) : nullptr; }
  /// due() was loaded, or was refused and is not tried again.
  void note_loaded() { loaded_ = player_.volume(); }
  /// The renderer is new: what is on show must be loaded again.
  void forget_loaded() { loaded_.reset(); }

  /// Lets the kept volumes go. Call it before the ring ends.
  void end() { go_live(); }

  std::optional<std::int64_t> next_change_ns() const { return player_.next_change_ns(); }

 private:
  void freeze(const Volume& shown, std::uint64_t volume_id = 0);
  bool go_live();
  const Volume* volume(std::uint32_t index) const;

  VolumeRing& ring_;
  CinePlayer player_;
  const Volume* newest_ = nullptr;  // while frozen: the one on show at the freeze
  std::optional<std::uint32_t> loaded_;
  bool freeze_waits_ = false;  // for the first volume
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
