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

Result<PictureOffer> PictureHub::coded(const StreamSettings& settings, bool key) {
  const StreamSettings by = coding_key(settings);
  Coding& coding = codings_[by];
  if (coding.offer.message != nullptr && (coding.offer.key || !key)) return coding.offer;
  if (coding.coder == nullptr) {
    auto coder = make_coder(by);
    if (!coder) return coder.error();
    coding.coder = std::move(*coder);
  }
  const Pixels pixels = coding.scaler.fitted(pixels_of(*on_show_), by);
  const auto code = coding.coder->encode(pixels, key);
  if (!code) return code.error();
  v1::ServerMessage message;
  v1::Picture& picture = *message.mutable_picture();
  describe(picture, *on_show_);
  picture.set_width(pixels.width);
  picture.set_height(pixels.height);
  picture.set_key_picture(code->key);
  put_pixels(picture, by.codec, code->bytes);
  if (by.with_depth) {
    picture.set_depth(packed_depth(*on_show_));
    picture.set_depth_unit_mm(kDepthUnitMm);
  }
  coding.offer = {.message = std::make_shared<const std::string>(message.SerializeAsString()),
                  .picture_id = on_show_->stamp.picture_id,
                  .scene_revision = on_show_->stamp.scene_revision,
                  .key = code->key};
  if (code->key) {
    coding.key_wanted = false;
    coding.key_ns = now_ns();
  }
  counters_.pictures_encoded.add();
  return coding.offer;
}

void PictureHub::show(const Picture& picture) {
  const std::int64_t shown_ns = picture.stamp.finished_time_ns;
  for (auto& [settings, coding] : codings_) coding.offer.message = nullptr;
  png_ = nullptr;
  on_show_ = &picture;
  std::vector<StreamSession*> unserved;
  for (StreamSession* session : sessions_) {
    if (!picture_due(session->settings().rate_hz, last_shown_ns_, shown_ns)) continue;
    const auto coding = codings_.find(coding_key(session->settings()));
    const bool key = coding != codings_.end() && coding->second.key_wanted;
    if (const auto offer = coded(session->settings(), key)) {
      session->offer(*offer);
    } else {
      unserved.push_back(session);
    }
  }
  last_shown_ns_ = shown_ns;
  for (StreamSession* session : unserved) session->unserved();
}

Result<void> PictureHub::add(StreamSession& session) {
  sessions_.insert(&session);
  return begin_anew(session);
}

Result<void> PictureHub::has_room(const StreamSettings& settings) {
  constexpr std::size_t kMostCodings = 16;
  forget_unused();
  if (codings_.contains(coding_key(settings)) || codings_.size() < kMostCodings) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("pictures are encoded in {} ways already, expected one of those or some patience",
                           kMostCodings)};
}

Result<void> PictureHub::begin_anew(StreamSession& session) {
  constexpr std::int64_t kStillNs = 500'000'000;
  constexpr std::int64_t kBetweenKeysNs = 1'000'000'000;
  forget_unused();
  if (on_show_ == nullptr) return {};
  const StreamSettings by = coding_key(session.settings());
  const auto known = codings_.find(by);
  if (by.codec == StreamSettings::Codec::kH264 && known != codings_.end()) {
    // A key picture is large, and goes to all who share the film: with the next one, where that comes soon.
    const std::int64_t now = now_ns();
    known->second.key_wanted = true;
    if (now - last_shown_ns_ < kStillNs || now - known->second.key_ns < kBetweenKeysNs) return {};
    known->second.offer.message = nullptr;
    const auto offer = coded(by, true);
    if (!offer) return offer.error();
    for (StreamSession* each : sessions_) {
      if (coding_key(each->settings()) == by) each->offer(*offer);
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
      if (coding_key(session->settings()) == entry.first) return false;
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
  const auto code = png_coder_->encode(pixels_of(*on_show_), true);
  if (!code) return code.error();
  png_ = std::make_shared<const std::string>(code->bytes.begin(), code->bytes.end());
  return png_;
}

}  // namespace fanlight
