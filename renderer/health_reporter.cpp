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
  if (health_.volume_refusal == Sentence(reason)) return;
  health_.volume_refusal = reason;
  send();
}

void HealthReporter::set_filter_left_out(bool left_out) {
  thread_owner_.check();
  if (health_.filter_left_out == left_out) return;
  health_.filter_left_out = left_out;
  send();
}

void HealthReporter::set_scene_refusal(std::uint64_t revision, std::string_view reason) {
  thread_owner_.check();
  const std::uint64_t refused = reason.empty() ? 0 : revision;
  if (health_.refused_revision == refused && health_.scene_refusal == Sentence(reason)) return;
  health_.scene_refusal = reason;
  health_.refused_revision = refused;
  send();
}

}  // namespace fanlight
