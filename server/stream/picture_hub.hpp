// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <unordered_set>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/model/picture.hpp"
#include "server/codec/picture_coder.hpp"
#include "server/metrics/server_counters.hpp"
#include "server/stream/picture_subscriber.hpp"

namespace fanlight {

/// Offers each picture to every subscriber of its view. Subscribers of one view with equal settings share one
/// encoding, and a picture that no subscriber needs is not encoded. Server thread only.
class PictureHub {
 public:
  using CoderFactory = std::function<Result<std::unique_ptr<PictureCoder>>(const StreamSettings&)>;

  /// Most encodings (view and settings) at a time.
  static constexpr std::size_t kMostEncodings = 16;

  /// Tests replace `make_coder` and `clock`.
  explicit PictureHub(
      ServerCounters& counters,
      CoderFactory make_coder = [](const StreamSettings& settings) { return fanlight::make_coder(settings); },
      Clock clock = now_ns)
      : counters_(counters), make_coder_(std::move(make_coder)), clock_(std::move(clock)) {}

  /// Offers the picture to all subscribers of its view whose rate has a picture due. The picture must stay
  /// unchanged until the next call for the same view. A subscriber receives its private view from the first
  /// picture of that view on. Calls encoding_failed() of each subscriber whose picture cannot be encoded.
  void show(const Picture& picture);

  /// The private view of the subscriber has ended: it receives the main view again.
  void forget_view(PictureSubscriber& subscriber);

  /// Subscribes, and offers the newest picture of the view if there is one. Error: it cannot be encoded.
  Result<void> add(PictureSubscriber& subscriber);

  /// Unsubscribes, and forgets the private view of the subscriber.
  void remove(PictureSubscriber& subscriber);

  /// Whether a subscriber may use these settings. Error, kUnavailable: there are kMostEncodings others.
  Result<void> has_room(std::uint64_t view_id, const StreamSettings& settings);

  /// The subscriber has other settings now, or has missed a picture that the next one depends on. Offers it
  /// the newest picture. If other subscribers share its H.264 stream, requests a key picture of that stream
  /// instead: at once if the picture does not change and the last key picture is old enough, else with the
  /// next picture.
  Result<void> resync(PictureSubscriber& subscriber);

  std::size_t subscriber_count() const { return subscribers_.size(); }

  /// The newest picture of a view; null before the first.
  const Picture* newest_picture(std::uint64_t view_id = 0) const {
    const auto shown = shown_.find(view_id);
    return shown == shown_.end() ? nullptr : shown->second.picture;
  }

  /// The newest picture of the main view as a PNG file, encoded once. Precondition: there is one.
  Result<SharedMessage> png();

 private:
  struct Encoding {
    std::unique_ptr<PictureCoder> coder;
    PictureScaler scaler;
    PictureOffer offer;             // of the newest picture; without a message until it is needed
    bool key_requested = false;     // for the next picture
    std::int64_t key_coded_ns = 0;  // when the last key picture was encoded
  };
  /// The view, and those settings that the encoding depends on.
  using EncodingKey = std::pair<std::uint64_t, StreamSettings>;
  struct Shown {
    const Picture* picture = nullptr;
    std::int64_t since_ns = 0;
  };

  static EncodingKey key_of(const PictureSubscriber& subscriber);
  Result<PictureOffer> encoded(const EncodingKey& encoding_key, bool key_picture);
  Result<void> resync_shared(const EncodingKey& encoding_key, Encoding& encoding, const Shown& shown);
  void drop_unused_encodings();

  ServerCounters& counters_;
  CoderFactory make_coder_;
  Clock clock_;
  std::unordered_set<PictureSubscriber*> subscribers_;
  std::map<EncodingKey, Encoding> encodings_;
  std::map<std::uint64_t, Shown> shown_;  // by view
  std::unique_ptr<PictureCoder> png_coder_;
  SharedMessage png_;  // of the newest picture of the main view; null until it is needed
};

}  // namespace fanlight
