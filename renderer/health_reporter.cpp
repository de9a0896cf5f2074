// SPDX-License-Identifier: Apache-2.0
#include "renderer/health_reporter.hpp"

#include <string>

namespace fanlight {

namespace {

constexpr std::size_t kSentenceBytes = 500;

}  // namespace

RenderHealth roomy_health() {
  // Copies keep the length of a text, and not the room that was reserved for it.
  const std::string room(kSentenceBytes, ' ');
  return {.cause = room, .refusal = room};
}

HealthReporter::HealthReporter(Mailbox<RenderHealth>* to) : to_(to) {
  for (std::string* text : {&health_.cause, &health_.refusal, &volume_refusal_, &scene_refusal_})
    text->reserve(kSentenceBytes);
}

void HealthReporter::set_state(RenderHealth::State state, std::string_view cause, std::int64_t now_ns) {
  if (state == health_.state && cause == health_.cause) return;
  if (state != health_.state) health_.since_ns = now_ns;
  health_.state = state;
  health_.cause.assign(cause);
  publish();
}

void HealthReporter::set_volume_refusal(std::string_view reason) {
  if (reason == volume_refusal_) return;
  volume_refusal_.assign(reason);
  update_refusal();
}

void HealthReporter::set_scene_refusal(std::string_view reason) {
  if (reason == scene_refusal_) return;
  scene_refusal_.assign(reason);
  update_refusal();
}

void HealthReporter::update_refusal() {
  health_.refusal.assign(volume_refusal_.empty() ? scene_refusal_ : volume_refusal_);
  publish();
}

void HealthReporter::publish() {
  if (to_ == nullptr) return;
  to_->draft() = health_;
  to_->publish();
}

}  // namespace fanlight
