// SPDX-License-Identifier: Apache-2.0
#include "server/stream/picture_hub.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "proto/fanlight.pb.h"
#include "server/stream/picture_message.hpp"

namespace fanlight {

namespace {

/// The settings without the rate, unless the coder depends on the pictures before: then the rate matters.
StreamSettings coding_settings(StreamSettings settings) {
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

/// Describes a picture and its encoded pixels as a serialised ServerMessage.
SharedMessage picture_message(const Picture& picture, const StreamSettings& settings, const Pixels& pixels,
                              const CodedPicture& coded) {
  v1::ServerMessage message;
  v1::Picture& body = *message.mutable_picture();
  describe(body, picture);
  body.set_width(pixels.width);
  body.set_height(pixels.height);
  body.set_key_picture(coded.key);
  put_pixels(body, settings.codec, coded.bytes);
  if (settings.with_depth) {
    body.set_depth(packed_depth(picture));
    body.set_depth_unit_mm(kDepthUnitMm);
  }
  return std::make_shared<const std::string>(message.SerializeAsString());
}

}  // namespace

PictureHub::EncodingKey PictureHub::key_of(const PictureSubscriber& subscriber) {
  return {subscriber.view_id(), coding_settings(subscriber.settings())};
}

Result<PictureOffer> PictureHub::encoded(const EncodingKey& encoding_key, bool key_picture) {
  const auto& [view_id, settings] = encoding_key;
  const Picture& picture = *shown_.at(view_id).picture;
  Encoding& encoding = encodings_[encoding_key];
  if (encoding.offer.message != nullptr && (encoding.offer.key || !key_picture)) return encoding.offer;
  if (encoding.coder == nullptr) {
    auto coder = make_coder_(settings);
    if (!coder) return coder.error();
    encoding.coder = std::move(*coder);
  }
  const Pixels pixels = encoding.scaler.fitted(pixels_of(picture), settings);
  const auto coded = encoding.coder->encode(pixels, key_picture);
  if (!coded) return coded.error();
  encoding.offer = {.message = picture_message(picture, settings, pixels, *coded),
                    .picture_id = picture.stamp.picture_id,
                    .scene_revision = picture.stamp.scene_revision,
                    .view_id = view_id,
                    .key = coded->key};
  if (coded->key) {
    encoding.key_requested = false;
    encoding.key_coded_ns = clock_();
  }
  counters_.pictures_encoded.add();
  return encoding.offer;
}

void PictureHub::show(const Picture& picture) {
  const std::uint64_t view_id = picture.stamp.view_id;
  const std::int64_t shown_ns = picture.stamp.finished_time_ns;
  for (auto& [encoding_key, encoding] : encodings_) {
    if (encoding_key.first == view_id) encoding.offer.message = nullptr;
  }
  if (view_id == 0) png_ = nullptr;
  const std::int64_t last_shown_ns = std::exchange(shown_[view_id], {&picture, shown_ns}).since_ns;
  std::vector<PictureSubscriber*> failed;
  for (PictureSubscriber* subscriber : subscribers_) {
    if (view_id != 0 && subscriber->id() == view_id) subscriber->set_view(view_id);
    if (subscriber->view_id() != view_id) continue;
    if (!picture_due(subscriber->settings().rate_hz, last_shown_ns, shown_ns)) continue;
    const auto encoding = encodings_.find(key_of(*subscriber));
    const bool key_picture = encoding != encodings_.end() && encoding->second.key_requested;
    if (const auto offer = encoded(key_of(*subscriber), key_picture)) {
      subscriber->offer(*offer);
    } else {
      failed.push_back(subscriber);
    }
  }
  for (PictureSubscriber* subscriber : failed) subscriber->encoding_failed();
}

Result<void> PictureHub::add(PictureSubscriber& subscriber) {
  subscribers_.insert(&subscriber);
  return resync(subscriber);
}

void PictureHub::remove(PictureSubscriber& subscriber) {
  subscribers_.erase(&subscriber);
  // The main view stays: its number is 0, which no subscriber has.
  shown_.erase(subscriber.id());
}

void PictureHub::forget_view(PictureSubscriber& subscriber) {
  shown_.erase(subscriber.id());
  if (subscriber.view_id() == 0) return;
  subscriber.set_view(0);
  if (auto begun = resync(subscriber); !begun) subscriber.encoding_failed();
}

Result<void> PictureHub::has_room(std::uint64_t view_id, const StreamSettings& settings) {
  drop_unused_encodings();
  if (encodings_.contains({view_id, coding_settings(settings)}) || encodings_.size() < kMostEncodings)
    return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("pictures are encoded in {} ways already, expected one of those or some patience",
                           kMostEncodings)};
}

Result<void> PictureHub::resync(PictureSubscriber& subscriber) {
  drop_unused_encodings();
  const auto shown = shown_.find(subscriber.view_id());
  if (shown == shown_.end()) return {};
  const EncodingKey encoding_key = key_of(subscriber);
  const auto encoding = encodings_.find(encoding_key);
  if (encoding_key.second.codec == StreamSettings::Codec::kH264 && encoding != encodings_.end())
    return resync_shared(encoding_key, encoding->second, shown->second);
  const auto offer = encoded(encoding_key, true);
  if (!offer) return offer.error();
  subscriber.offer(*offer);
  return {};
}

Result<void> PictureHub::resync_shared(const EncodingKey& encoding_key, Encoding& encoding,
                                       const Shown& shown) {
  constexpr std::int64_t kStillNs = 500'000'000;
  constexpr std::int64_t kBetweenKeysNs = 1'000'000'000;
  // A key picture is large and all subscribers of the stream receive it. If the next picture comes soon, that
  // one becomes the key picture.
  const std::int64_t now = clock_();
  encoding.key_requested = true;
  if (now - shown.since_ns < kStillNs || now - encoding.key_coded_ns < kBetweenKeysNs) return {};
  encoding.offer.message = nullptr;
  const auto offer = encoded(encoding_key, true);
  if (!offer) return offer.error();
  for (PictureSubscriber* each : subscribers_) {
    if (key_of(*each) == encoding_key) each->offer(*offer);
  }
  return {};
}

void PictureHub::drop_unused_encodings() {
  std::erase_if(encodings_, [this](const auto& entry) {
    return std::ranges::none_of(subscribers_, [&](const PictureSubscriber* subscriber) {
      return key_of(*subscriber) == entry.first;
    });
  });
}

Result<SharedMessage> PictureHub::png() {
  if (png_ != nullptr) return png_;
  if (png_coder_ == nullptr) {
    auto coder = make_coder_({.codec = StreamSettings::Codec::kPng});
    if (!coder) return coder.error();
    png_coder_ = std::move(*coder);
  }
  const auto coded = png_coder_->encode(pixels_of(*newest_picture()), true);
  if (!coded) return coded.error();
  png_ = std::make_shared<const std::string>(coded->bytes.begin(), coded->bytes.end());
  return png_;
}

}  // namespace fanlight
