// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/scene_fallback.hpp"

#include <algorithm>

namespace fanlight {

bool SceneFallback::falls_back(const Error& error, std::int64_t now_ns) {
  const bool other = in_force_.revision != proven_.revision || in_force_.deadline != proven_.deadline;
  if (error.code == ErrorCode::kLost || !other) return false;
  refusal_ = error.message;
  refused_revision_ = in_force_.revision;
  refused_ns_ = now_ns;
  in_force_ = proven_;
  return true;
}

void SceneFallback::note_drawn() {
  proven_ = in_force_;
  if (in_force_.revision == wanted_.revision) refusal_.clear();
}

std::optional<std::int64_t> SceneFallback::next_try_ns() const {
  if (refusal_.empty() || in_force_.revision == wanted_.revision) return {};
  return refused_ns_ + rest_ns_;
}

void SceneFallback::try_again(std::int64_t now_ns) {
  const auto try_ns = next_try_ns();
  if (!try_ns || now_ns < *try_ns) return;
  in_force_ = wanted_;
  rest_ns_ = std::min(2 * rest_ns_, kMostRestNs);
}

}  // namespace fanlight
