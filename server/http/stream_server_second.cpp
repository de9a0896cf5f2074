// SPDX-License-Identifier: Apache-2.0
// StreamServer: what it does once a second, its file of presets, and its doors beside HTTP.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/base/file_replacement.hpp"
#include "server/http/stream_server.hpp"
#include "server/igtl/igtl_state.hpp"

namespace fanlight {

IgtlServer::Dependencies StreamServer::igtl_dependencies() {
  return {.counters = dependencies_.counters,
          .commands = {.counters = dependencies_.counters,
                       .scene_store = scene_store_,
                       .control = control_,
                       .audit = audit_,
                       .sessions = sessions_},
          .state = [this] { return igtl_state(liveness_.report()); },
          .newest_picture = [this] { return hub_.newest_picture(); },
          .executor = hub_config().executor,
          .wants_changed = [this] { liveness_watch_.update(); },
          .volume_orders = dependencies_.volume_orders,
          .volume_answers = dependencies_.volume_answers,
          .frames = dependencies_.frames,
          .write_frame = dependencies_.write_frame};
}

RtpSender::Dependencies StreamServer::rtp_dependencies() {
  return {.counters = dependencies_.counters,
          .hub = hub_,
          .id = sessions_.next_id(),
          .liveness = liveness_,
          .executor = hub_config().executor,
          .title = [this] { return config_.facts.title; },
          .changed =
              [this] {
                relayed_ = rtp_->sending();
                sessions_.relay_changed();
                liveness_watch_.update();
              }};
}

void StreamServer::start_rtp() {
  if (!rtp_ || !config_.rtp->at_start) return;
  const auto started = rtp_->start();
  if (!started) spdlog::error("pictures are not sent to {}: {}", rtp_->to(), started.error().message);
  audit_.note({.role = Role::kAdmin, .name = "fanlight"},
              {.what = "rtp", .result = started ? "done" : "failed: " + started.error().message},
              {{"wish", "start"}, {"to", rtp_->to()}, {"by", "configuration"}});
}

std::size_t StreamServer::other_clients() const {
  return (igtl_ && igtl_->wants_pictures() ? 1 : 0) + (rtp_ && rtp_->sending() ? 1 : 0);
}

void StreamServer::load_presets() {
  std::vector<std::string> troubles = presets_.load(config_.presets);
  if (troubles.empty()) return;
  const std::string aside = config_.presets.string() + ".unread";
  std::error_code failure;
  std::filesystem::copy_file(config_.presets, aside, std::filesystem::copy_options::overwrite_existing,
                             failure);
  for (const std::string& trouble : troubles)
    spdlog::warn("{}{}", trouble, failure ? "" : "; the file as it was is " + aside);
}

void StreamServer::presets_changed() {
  sessions_.presets_changed();
  if (config_.presets.empty()) return;
  presets_unwritten_ = true;
  if (!writing_presets_) write_presets();
}

bool StreamServer::save_presets(const std::string& text) const {
  try {
    std::error_code none;
    std::filesystem::create_directories(config_.presets.parent_path(),
                                        none);  // where it fails, so does the file
    const auto written = replace_file(config_.presets, text);
    if (!written) spdlog::error("the presets could not be saved: {}", written.error().message);
    return static_cast<bool>(written);
  } catch (const std::bad_alloc&) {
    return false;  // the next change, or the end, tries again
  }
}

void StreamServer::write_presets() {
  const auto saved = std::make_shared<bool>(false);
  const auto done = std::make_shared<std::function<void()>>([this, saved] {
    writing_presets_ = false;
    if (!*saved) {
      presets_unwritten_ = true;
    } else if (presets_unwritten_) {
      write_presets();
    }
  });
  encoders_.submit(EncoderLane::kHeavy, [this, done, saved, text = presets_.json()] {
    *saved = save_presets(text);
    post(done);
  });
  writing_presets_ = true;
  presets_unwritten_ = false;
}

void StreamServer::start_second() {
  second_.expires_after(std::chrono::seconds(1));
  second_.async_wait([this, link = second_chain_.link()](boost::system::error_code failure) {
    if (failure) return;
    second_passed();
    start_second();
  });
}

void StreamServer::second_passed() {
  if (liveness_.driver_silent_ns() > config_.most_driver_ms * 1'000'000) {
    fail({ErrorCode::kLost,
          fmt::format("a call of the GPU's driver has not returned for {} s; expected a driver "
                      "that answers",
                      config_.most_driver_ms / 1000)});
  }
  notify_sessions_of_second();  // first: it frees the memory of sessions that leave
  listener_.second_passed();
  if (igtl_) igtl_->second_passed();
  rest_api_.answer_waiting(now_ns());
  reload_credentials(false);
  reload_certificates(false);
  lapse_control();
  audit_.second_passed();
  if (const std::string notice = audit_.take_notice(); !notice.empty()) spdlog::warn("{}", notice);
  dependencies_.counters.audit_lines_lost.set(audit_.lines_lost());
  if (dependencies_.second_passed) dependencies_.second_passed(liveness_.report());
}

void StreamServer::reload_credentials(bool in_any_case) {
  std::string trouble;
  if (!access_.reload(trouble, in_any_case)) return;
  audit_.note({.name = "fanlight"},
              {.what = "credentials_read", .result = trouble.empty() ? "done" : trouble});
  if (trouble.empty()) {
    spdlog::info("read the credentials again");
  } else {
    spdlog::error("the credentials stay as they were: {}", trouble);
  }
}

void StreamServer::reload_certificates(bool in_any_case) {
  const auto result = listener_.reload_certificates(in_any_case);
  if (!result) return;
  audit_.note({.name = "fanlight"}, {.what = "certificates_read", .result = *result});
  spdlog::info("the certificates were read again: {}", *result);
}

void StreamServer::lapse_control() {
  if (!control_.expire(now_ns() / 1'000'000)) return;
  audit_.note({.name = "fanlight"}, {.what = "control", .result = "lapsed"},
              {{"in_control", control_.state().holder.session}});
  sessions_.control_changed();
}

void StreamServer::notify_sessions_of_second() {
  end_views(views_.second_passed(now_ns()));
  for (const auto& session : sessions_.all()) session->second_passed();
}

void StreamServer::end_views(const std::vector<ViewAdmission::EndedView>& ended) {
  for (const ViewAdmission::EndedView& view : ended) {
    dependencies_.counters.private_views_ended.add();
    sessions_.view_ended(view.session, view.reason);
  }
}

}  // namespace fanlight
