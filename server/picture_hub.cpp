#include "server/picture_hub.hpp"

#include <fmt/format.h>

#include <vector>

#include "proto/clock.hpp"
#include "proto/fanlight.pb.h"
#include "server/picture_message.hpp"
#include "server/stream_session.hpp"

namespace fanlight {

namespace {

/// Of the settings, what the code depends on: which pictures come matters only where a coder remembers.
StreamSettings coding_key(StreamSettings settings) {
  if (!settings.remembers()) settings.rate_hz = 0;
  return settings;
}

void put_pixels(v1::Picture& message, StreamSettings::Codec codec, std::span<const std::uint8_t> bytes) {
  switch (codec) {
    case StreamSettings::Codec::kJpeg:
      return message.set_jpeg(bytes.data(), bytes.size());
    case StreamSettings::Codec::kPng:
      return message.set_png(bytes.data(), bytes.size());
    case StreamSettings::Codec::kH264:
      return message.set_h264(bytes.data(), bytes.size());
  }
}

}  // namespace

PictureHub::Way PictureHub::way_of(const StreamSession& session) {
  return {session.view_id(), coding_key(session.settings())};
}

Result<PictureOffer> PictureHub::coded(const Way& way, bool key) {
  const StreamSettings& by = way.second;
  const Picture& on_show = *on_show_.at(way.first).picture;
  Coding& coding = codings_[way];
  if (coding.offer.message != nullptr && (coding.offer.key || !key)) return coding.offer;
  if (coding.coder == nullptr) {
    auto coder = make_coder(by);
    if (!coder) return coder.error();
    coding.coder = std::move(*coder);
  }
  const Pixels pixels = coding.scaler.fitted(pixels_of(on_show), by);
  const auto code = coding.coder->encode(pixels, key);
  if (!code) return code.error();
  v1::ServerMessage message;
  v1::Picture& picture = *message.mutable_picture();
  describe(picture, on_show);
  picture.set_width(pixels.width);
  picture.set_height(pixels.height);
  picture.set_key_picture(code->key);
  put_pixels(picture, by.codec, code->bytes);
  if (by.with_depth) {
    picture.set_depth(packed_depth(on_show));
    picture.set_depth_unit_mm(kDepthUnitMm);
  }
  coding.offer = {.message = std::make_shared<const std::string>(message.SerializeAsString()),
                  .picture_id = on_show.stamp.picture_id,
                  .scene_revision = on_show.stamp.scene_revision,
                  .view_id = way.first,
                  .key = code->key};
  if (code->key) {
    coding.key_wanted = false;
    coding.key_ns = now_ns();
  }
  counters_.pictures_encoded.add();
  return coding.offer;
}

void PictureHub::show(const Picture& picture) {
  const std::uint64_t view_id = picture.stamp.view_id;
  const std::int64_t shown_ns = picture.stamp.finished_time_ns;
  for (auto& [way, coding] : codings_) {
    if (way.first == view_id) coding.offer.message = nullptr;
  }
  if (view_id == 0) png_ = nullptr;
  const std::int64_t last_shown_ns = std::exchange(on_show_[view_id], {&picture, shown_ns}).since_ns;
  std::vector<StreamSession*> unserved;
  for (StreamSession* session : sessions_) {
    if (view_id != 0 && session->id() == view_id) session->see(view_id);
    if (session->view_id() != view_id) continue;
    if (!picture_due(session->settings().rate_hz, last_shown_ns, shown_ns)) continue;
    const auto coding = codings_.find(way_of(*session));
    const bool key = coding != codings_.end() && coding->second.key_wanted;
    if (const auto offer = coded(way_of(*session), key)) {
      session->offer(*offer);
    } else {
      unserved.push_back(session);
    }
  }
  for (StreamSession* session : unserved) session->unserved();
}

Result<void> PictureHub::add(StreamSession& session) {
  sessions_.insert(&session);
  return begin_anew(session);
}

void PictureHub::remove(StreamSession& session) {
  sessions_.erase(&session);
  // 0 is the main view, and no session's number.
  on_show_.erase(session.id());
}

void PictureHub::forget_view(StreamSession& session) {
  on_show_.erase(session.id());
  if (session.view_id() == 0) return;
  session.see(0);
  if (auto begun = begin_anew(session); !begun) session.unserved();
}

Result<void> PictureHub::has_room(std::uint64_t view_id, const StreamSettings& settings) {
  constexpr std::size_t kMostCodings = 16;
  forget_unused();
  if (codings_.contains({view_id, coding_key(settings)}) || codings_.size() < kMostCodings) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("pictures are encoded in {} ways already, expected one of those or some patience",
                           kMostCodings)};
}

Result<void> PictureHub::begin_anew(StreamSession& session) {
  constexpr std::int64_t kStillNs = 500'000'000;
  constexpr std::int64_t kBetweenKeysNs = 1'000'000'000;
  forget_unused();
  const auto shown = on_show_.find(session.view_id());
  if (shown == on_show_.end()) return {};
  const Way by = way_of(session);
  const auto known = codings_.find(by);
  if (by.second.codec == StreamSettings::Codec::kH264 && known != codings_.end()) {
    // A key picture is large, and goes to all who share the film: with the next one, where that comes soon.
    const std::int64_t now = now_ns();
    known->second.key_wanted = true;
    if (now - shown->second.since_ns < kStillNs || now - known->second.key_ns < kBetweenKeysNs) return {};
    known->second.offer.message = nullptr;
    const auto offer = coded(by, true);
    if (!offer) return offer.error();
    for (StreamSession* each : sessions_) {
      if (way_of(*each) == by) each->offer(*offer);
    }
    return {};
  }
  const auto offer = coded(by, true);
  if (!offer) return offer.error();
  session.offer(*offer);
  return {};
}

void PictureHub::forget_unused() {
  std::erase_if(codings_, [this](const auto& entry) {
    for (const StreamSession* session : sessions_) {
      if (way_of(*session) == entry.first) return false;
    }
    return true;
  });
}

Result<SharedMessage> PictureHub::png() {
  if (png_ != nullptr) return png_;
  if (png_coder_ == nullptr) {
    auto coder = make_coder({.codec = StreamSettings::Codec::kPng});
    if (!coder) return coder.error();
    png_coder_ = std::move(*coder);
  }
  const auto code = png_coder_->encode(pixels_of(*on_show()), true);
  if (!code) return code.error();
  png_ = std::make_shared<const std::string>(code->bytes.begin(), code->bytes.end());
  return png_;
}

}  // namespace fanlight
