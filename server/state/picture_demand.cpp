// SPDX-License-Identifier: Apache-2.0
#include "server/state/picture_demand.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

void PictureDemand::asked(std::int64_t now_ns) {
  if (needed_until_ns_) needed_until_ns_ = std::max(*needed_until_ns_, now_ns + kLingerNs);
}

void PictureDemand::picture_shown(std::int64_t now_ns) {
  if (!needed_until_ns_) needed_until_ns_ = now_ns + kLingerNs;
}

bool PictureDemand::update(std::size_t displays, bool recording, std::int64_t now_ns) {
  if (audience_ == nullptr) return false;
  if (displays > 0 || recording) asked(now_ns);
  const bool rests = needed_until_ns_ && now_ns >= *needed_until_ns_;
  if (rests == std::exchange(resting_, rests)) return false;
  audience_->set_present(!rests);
  return true;
}

}  // namespace fanlight
