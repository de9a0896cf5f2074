// SPDX-License-Identifier: Apache-2.0
#include "server/service/scene_guard.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace fanlight {

void SceneGuard::update(std::int64_t now_ns) {
  const SceneStore& store = state_.scene_store;
  const auto event = watch_.update({.in_force = store.in_force().revision,
                                    .shown = store.shown_revision(),
                                    .refused = state_.liveness.health().refused_revision,
                                    .are_pictures_expected = state_.liveness.renders()},
                                   now_ns);
  if (event == SceneWatch::Event::kNotShown) {
    state_.counters.scene_changes_overdue.add();
    spdlog::warn("{} (revision {}; the picture shows revision {})", trouble(), store.in_force().revision,
                 store.shown_revision());
  } else if (event == SceneWatch::Event::kWithdrawn) {
    withdraw();
  }
}

std::string SceneGuard::trouble() const {
  const RenderHealth& health = state_.liveness.health();
  if (!watch_.is_overdue()) {
    return health.filter_left_out ? "The speckle filter is not applied, because the GPU has no memory for it."
                                  : "";
  }
  if (health.refused_revision <= state_.scene_store.shown_revision())
    return "The last change is not shown yet: the renderer is still working on it.";
  return fmt::format("The last change is not shown, because the GPU cannot draw it: {}.",
                     health.scene_refusal.view());
}

void SceneGuard::withdraw() {
  const std::string reason(state_.liveness.health().scene_refusal.view());
  state_.scene_store.return_to_shown();
  state_.counters.scene_changes_withdrawn.add();
  spdlog::error("the last change was withdrawn, because the GPU could not draw it for {} s: {}",
                SceneWatch::kWithdrawalNs / 1'000'000'000, reason);
  audit_.note({.name = "fanlight"}, {.what = "scene", .result = "withdrawn: " + reason},
              {{"revision", state_.scene_store.in_force().revision}});
  sessions_.scene_withdrawn(
      fmt::format("The last change was withdrawn, because the GPU could not draw it: {}.", reason));
}

}  // namespace fanlight
