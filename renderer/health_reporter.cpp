// SPDX-License-Identifier: Apache-2.0
#include "renderer/health_reporter.hpp"

namespace fanlight {

void HealthReporter::set_state(RenderHealth::State state, std::string_view cause, std::int64_t now_ns) {
  thread_owner_.check();
  if (state == health_.state && Sentence(cause) == health_.cause) return;
  if (state != health_.state) health_.since_ns = now_ns;
  health_.state = state;
  health_.cause = cause;
  send();
}

void HealthReporter::set_volume_refusal(std::string_view reason) {
  thread_owner_.check();
  if (volume_refusal_ == Sentence(reason)) return;
  volume_refusal_ = reason;
  update_refusal();
}

void HealthReporter::set_scene_refusal(std::string_view reason) {
  thread_owner_.check();
  if (scene_refusal_ == Sentence(reason)) return;
  scene_refusal_ = reason;
  update_refusal();
}

void HealthReporter::update_refusal() {
  health_.refusal = volume_refusal_.empty() ? scene_refusal_ : volume_refusal_;
  send();
}

}  // namespace fanlight
