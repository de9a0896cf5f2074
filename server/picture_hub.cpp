#include "server/picture_hub.hpp"

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
  counters_.pictures_encoded.add();
  return coding.offer;
}

Result<void> PictureHub::show(const Picture& picture) {
  const std::int64_t shown_ns = picture.stamp.finished_time_ns;
  for (auto& [settings, coding] : codings_) coding.offer.message = nullptr;
  on_show_ = &picture;
  for (StreamSession* session : sessions_) {
    if (!picture_due(session->settings().rate_hz, last_shown_ns_, shown_ns)) continue;
    const auto offer = coded(session->settings(), false);
    if (!offer) return offer.error();
    session->offer(*offer);
  }
  last_shown_ns_ = shown_ns;
  return {};
}

Result<void> PictureHub::add(StreamSession& session) {
  sessions_.insert(&session);
  return begin_anew(session);
}

Result<void> PictureHub::begin_anew(StreamSession& session) {
  forget_unused();
  if (on_show_ == nullptr) return {};
  const StreamSettings by = coding_key(session.settings());
  const auto offer = coded(by, true);
  if (!offer) return offer.error();
  if (!offer->key) {
    return Error{ErrorCode::kBroken,
                 "a picture that should need none before it does, expected the encoder to obey"};
  }
  if (by.codec != StreamSettings::Codec::kH264) {
    session.offer(*offer);
    return {};
  }
  // What comes next builds upon this one, for all who share it.
  for (StreamSession* each : sessions_) {
    if (coding_key(each->settings()) == by) each->offer(*offer);
  }
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

Result<std::string> PictureHub::png() {
  const StreamSettings settings{.codec = StreamSettings::Codec::kPng};
  if (png_ == nullptr) {
    auto coder = make_coder(settings);
    if (!coder) return coder.error();
    png_ = std::move(*coder);
  }
  const auto code = png_->encode(pixels_of(*on_show_), true);
  if (!code) return code.error();
  return std::string(code->bytes.begin(), code->bytes.end());
}

}  // namespace fanlight
