// SPDX-License-Identifier: Apache-2.0
#include "server/state/recording_proxy.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <ctime>
#include <tuple>
#include <utility>

#include "server/state/path_privacy.hpp"
#include "server/state/picture_note.hpp"

namespace fanlight {

namespace {

using State = RecordingStatus::State;

constexpr std::array<std::pair<std::string_view, RecordingWish>, 3> kWords = {{
    {"start", RecordingWish::kStart},
    {"stop", RecordingWish::kStop},
    {"keep", RecordingWish::kKeep},
}};

std::string name_of(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

}  // namespace

std::optional<RecordingWish> recording_wish(std::string_view word) {
  for (const auto& [known, wish] : kWords) {
    if (known == word) return wish;
  }
  return std::nullopt;
}

std::string_view recording_word(RecordingWish wish) {
  return kWords[static_cast<std::size_t>(wish)].first;
}

RecordingProxy::RecordingProxy(Config config, std::optional<RecordingLink> link,
                               std::function<std::int64_t()> utc_s)
    : config_(std::move(config)), link_(link), utc_s_(std::move(utc_s)) {
  if (!link_) return;
  if (config_.at_start) {
    (void)request(RecordingWish::kStart);
  } else if (keeps_ring()) {
    order(ring_order());
  }
}

/// A name that no file has: two recordings may begin within one second.
std::filesystem::path RecordingProxy::free_name(std::string_view begin) {
  const std::string time =
      fmt::format("{:%Y-%m-%dT%H%M%SZ}", fmt::gmtime(static_cast<std::time_t>(utc_s_())));
  for (int number = 1;; ++number) {
    const std::string further = number == 1 ? "" : fmt::format("_{}", number);
    std::string name = fmt::format("{}-{}{}.igs.mha", begin, time, further);
    std::error_code failure;
    if (name == last_names_[std::string(begin)] || std::filesystem::exists(config_.folder / name, failure))
      continue;
    return config_.folder / (last_names_[std::string(begin)] = std::move(name));
  }
}

RecordingOrder RecordingProxy::ring_order() {
  return {.wish = RecordingOrder::Wish::kRecord,
          .path = free_name("ring"),
          .form = config_.form,
          .ring_s = config_.last_s};
}

bool RecordingProxy::order(RecordingOrder order) {
  order.number = ordered_ + 1;
  if (!link_->send(std::move(order))) return false;
  ++ordered_;
  return true;
}

Result<std::string> RecordingProxy::request(RecordingWish wish) {
  const auto unavailable = [](std::string sentence) {
    return Error{ErrorCode::kUnavailable, std::move(sentence)};
  };
  if (!link_) {
    return unavailable(
        "this server has no folder for recordings, expected it to be started with --recordings");
  }
  if (status_.over)
    return unavailable(without_path(status_.trouble, config_.folder.string(), "the folder for recordings"));
  const Error busy = unavailable("the recorder has many orders to carry out, expected a later request");
  switch (wish) {
    case RecordingWish::kStart: {
      if (!recording_.empty()) {
        return unavailable(
            fmt::format("{} is being recorded, expected its end first", recording_.filename().string()));
      }
      const std::filesystem::path path = free_name("fanlight");
      if (!order({.wish = RecordingOrder::Wish::kRecord,
                  .drops = true,
                  .path = path,
                  .form = config_.form,
                  .most_s = config_.most_s}))
        return busy;
      recording_ = path;
      return path.filename().string();
    }
    case RecordingWish::kStop: {
      if (recording_.empty()) return unavailable("nothing is being recorded, expected a recording to stop");
      if (!order(keeps_ring() ? ring_order() : RecordingOrder{})) return busy;
      return std::exchange(recording_, {}).filename().string();
    }
    case RecordingWish::kKeep: {
      if (!keeps_ring()) {
        return unavailable(
            "this server keeps no last seconds, expected it to be started with --recording-last");
      }
      if (!recording_.empty()) {
        return unavailable(fmt::format("{} is being recorded, which keeps what comes; expected its end first",
                                       recording_.filename().string()));
      }
      const std::filesystem::path kept = free_name("fanlight");
      RecordingOrder next = ring_order();
      next.end_path = kept;
      if (!order(std::move(next))) return busy;
      return kept.filename().string();
    }
  }
  return unavailable("the wish is not known, expected start, stop or keep");
}

RecordingProxy::News RecordingProxy::update() {
  if (!link_) return {};
  const RecordingStatus* newest = link_->status.newest();
  if (newest == nullptr) return {};
  const auto facts = [](const RecordingStatus& status) {
    return std::tuple(status.state, status.ring, status.file, status.trouble, status.finished);
  };
  News news{.read = true,
            .changed = facts(status_) != facts(*newest),
            .ended = status_.finished != newest->finished};
  status_ = *newest;
  const bool under_way = status_.state == State::kRecording || status_.state == State::kNoRoom;
  if (!recording_.empty() && status_.order_done == ordered_ && !under_way) {
    recording_.clear();  // it has reached its limit
    news.changed = true;
    if (keeps_ring()) order(ring_order());
  }
  return news;
}

void RecordingProxy::picture_shown(const Picture& picture, PictureSize usual, const SceneStore& scenes) {
  if (!link_) return;
  const PictureStamp& stamp = picture.stamp;
  if (stamp.scene_revision != noted_revision_) {
    const Scene* const scene = scenes.of_revision(stamp.scene_revision);
    if (scene == nullptr || !link_->pictures.put(scene_note(stamp.scene_revision, *scene))) return;
    noted_revision_ = stamp.scene_revision;
  }
  if (is_active()) link_->pictures.put(picture_note(stamp, {picture.width, picture.height}, usual));
}

v1::RecordingStatus RecordingProxy::message() const {
  v1::RecordingStatus message;
  message.set_available(link_.has_value());
  if (!link_) return message;
  message.set_state(static_cast<v1::RecordingStatus::State>(status_.state));
  message.set_keeps_last_s(config_.last_s);
  message.set_ring(status_.ring);
  if (is_active()) {
    message.set_file(name_of(status_.file));
    message.set_frames(status_.frames);
    message.set_bytes(status_.bytes);
    message.set_duration_s(status_.duration_s);
    message.set_frames_missed(status_.frames_missed);
  }
  message.set_finish_share(status_.finish_share);
  message.set_trouble(without_path(status_.trouble, config_.folder.string(), "the folder for recordings"));
  message.set_last_file(name_of(status_.last_file));
  message.set_last_frames(status_.last_frames);
  message.set_last_duration_s(status_.last_duration_s);
  message.set_last_trouble(
      without_path(status_.last_trouble, config_.folder.string(), "the folder for recordings"));
  return message;
}

}  // namespace fanlight
