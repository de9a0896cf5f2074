// SPDX-License-Identifier: Apache-2.0
#include "renderer/cine.hpp"

namespace fanlight {

void Cine::advance(const Volume* shown, std::int64_t now_ns) {
  thread_owner_.check();
  player_.advance(now_ns);
  if (freeze_waits_ && shown != nullptr) freeze(*shown);
}

bool Cine::obey(const CineOrder& order, const Volume* shown, std::int64_t now_ns) {
  thread_owner_.check();
  if (order.wish == CineOrder::Wish::kLive) return go_live();
  if (order.wish == CineOrder::Wish::kFreeze) {
    freeze_waits_ = shown == nullptr;
    if (!is_frozen() && shown != nullptr) freeze(*shown, order.volume_id);
    return false;
  }
  player_.obey(order, now_ns);
  return false;
}

void Cine::freeze(const Volume& shown, std::uint64_t volume_id) {
  freeze_waits_ = false;
  newest_ = &shown;
  auto& times_ns = player_.capture_times_ns();
  times_ns.clear();
  std::optional<std::uint32_t> wanted;
  for (const Volume* const kept : ring_.keep()) {
    if (kept->stamp().volume_id == volume_id) wanted = static_cast<std::uint32_t>(times_ns.size());
    times_ns.push_back(kept->stamp().last_capture_time_ns);
  }
  times_ns.push_back(shown.stamp().last_capture_time_ns);
  player_.freeze();
  loaded_ = player_.volume();
  if (wanted) player_.seek(*wanted);
}

bool Cine::go_live() {
  const bool older_is_shown = is_frozen() && (!loaded_ || volume(*loaded_) != newest_);
  freeze_waits_ = false;
  player_.go_live();
  ring_.release_kept();
  newest_ = nullptr;
  loaded_.reset();
  return older_is_shown;
}

const Volume* Cine::volume(std::uint32_t index) const {
  const auto kept = ring_.kept();
  return index < kept.size() ? kept[index] : newest_;
}

const Volume* Cine::due() const {
  return is_frozen() && loaded_ != player_.volume() ? volume(player_.volume()) : nullptr;
}

CineStatus Cine::status() const {
  CineStatus status = player_.status();
  status.capacity = ring_.most_kept();
  if (is_frozen()) status.volume_id = volume(player_.volume())->stamp().volume_id;
  return status;
}

}  // namespace fanlight
