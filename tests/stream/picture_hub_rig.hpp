// SPDX-License-Identifier: Apache-2.0
// A PictureHub without sockets and codecs.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "server/stream/picture_hub.hpp"

namespace fanlight::test {

/// Keeps what the hub tells it.
class SpySubscriber : public PictureSubscriber {
 public:
  explicit SpySubscriber(std::uint64_t id, const StreamSettings& settings = {.quality = 80})
      : id_(id), settings_(settings) {}

  std::uint64_t id() const override { return id_; }
  std::uint64_t view_id() const override { return view_id_; }
  const StreamSettings& settings() const override { return settings_; }
  void set_view(std::uint64_t view_id) override { view_id_ = view_id; }
  bool privileged() const override { return privileged_role; }
  void offer(const PictureOffer& picture) override { offers.push_back(picture); }
  void encoding_failed() override { ++failures; }

  void set_settings(const StreamSettings& settings) { settings_ = settings; }
  std::vector<std::uint64_t> picture_ids() const {
    std::vector<std::uint64_t> ids;
    for (const PictureOffer& offer : offers) ids.push_back(offer.picture_id);
    return ids;
  }

  std::vector<PictureOffer> offers;
  int failures = 0;
  bool privileged_role = false;

 private:
  std::uint64_t id_;
  std::uint64_t view_id_ = 0;
  StreamSettings settings_;
};

/// What the coders of a hub did.
struct CoderLog {
  int encoded = 0;
  int quality_without_memory = -1;  ///< settings whose encoding finds no memory
  int failing_quality = -1;         ///< settings whose encoding fails
};

/// Encodes nothing; only the first picture and requested ones are key pictures if the codec is H.264.
class SpyCoder : public PictureCoder {
 public:
  SpyCoder(CoderLog& log, const StreamSettings& settings) : log_(log), settings_(settings) {}

  Result<CodedPicture> encode(const Pixels& pixels, bool key) override {
    if (settings_.quality == log_.quality_without_memory) throw std::bad_alloc();
    if (settings_.quality == log_.failing_quality)
      return Error{ErrorCode::kBroken, "no encoding, expected one"};
    ++log_.encoded;
    const bool first = std::exchange(first_, false);
    return CodedPicture{.bytes = pixels.rgba,
                        .key = settings_.codec != StreamSettings::Codec::kH264 || key || first};
  }

 private:
  CoderLog& log_;
  StreamSettings settings_;
  bool first_ = true;
};

class PictureHubTest : public testing::Test {
 protected:
  static constexpr std::int64_t kSecondNs = 1'000'000'000;
  static constexpr StreamSettings kFilm{.codec = StreamSettings::Codec::kH264, .bit_rate_kbps = 4000};

  /// Shows a picture of 2 x 2 pixels; the hub keeps a pointer to it.
  void show(std::uint64_t picture_id, std::uint64_t view_id = 0) {
    Picture& picture = pictures_[view_id];
    picture.stamp = {.view_id = view_id, .picture_id = picture_id};
    picture.stamp.finished_time_ns = now_ns_;
    picture.width = picture.height = 2;
    picture.rgba.assign(16, 7);
    hub_.show(picture);
  }
  void pass(std::int64_t ns) { now_ns_ += ns; }

  std::int64_t now_ns_ = 5 * kSecondNs;
  CoderLog log_;
  std::map<std::uint64_t, Picture> pictures_;
  ServerCounters counters_;
  PictureHub::Config config() {
    PictureHub::Config config;
    config.make_coder = [this](const StreamSettings& settings) -> Result<std::unique_ptr<PictureCoder>> {
      return std::unique_ptr<PictureCoder>(std::make_unique<SpyCoder>(log_, settings));
    };
    config.clock = [this] { return now_ns_; };
    config.executor = [this](EncoderLane lane, std::function<void()> work, std::function<void()> done) {
      jobs_.push_back({lane, std::move(work), std::move(done)});
      if (at_once_) finish_jobs();
    };
    return config;
  }
  /// Carries out the jobs that were started, also those that start meanwhile.
  void finish_jobs() {
    while (!jobs_.empty()) {
      const Started job = std::move(jobs_.front());
      jobs_.pop_front();
      job.work();
      job.done();
    }
  }
  Result<void> room_for(const StreamSettings& settings, bool privileged = true) {
    SpySubscriber asking(1000);
    asking.privileged_role = privileged;
    return hub_.has_room(asking, settings);
  }

  struct Started {
    EncoderLane lane;
    std::function<void()> work;
    std::function<void()> done;
  };
  std::deque<Started> jobs_;
  bool at_once_ = true;
  PictureHub hub_{counters_, config()};
};

}  // namespace fanlight::test
