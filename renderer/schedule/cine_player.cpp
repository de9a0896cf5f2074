// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/cine_player.hpp"

#include <algorithm>

namespace fanlight {

namespace {

// Volumes of a source that is as fast as it can be may have one capture time.
constexpr std::int64_t kLeastNs = 10'000'000;
// A gap between two volumes, such as a pause of the source, is not waited for.
constexpr std::int64_t kMostNs = 1'000'000'000;
// So long the only volume is on show, or the last one of two with equal times.
constexpr std::int64_t kUsualNs = 100'000'000;

double seconds(std::int64_t duration_ns) {
  return static_cast<double>(duration_ns) / 1e9;
}

}  // namespace

void CinePlayer::freeze() {
  frozen_ = true;
  playing_ = false;
  volume_ = count() - 1;
}

void CinePlayer::seek(std::uint32_t volume) {
  playing_ = false;
  volume_ = std::min(volume, count() - 1);
}

void CinePlayer::go_live() {
  frozen_ = playing_ = false;
  volume_ = 0;
  capture_times_ns_.clear();
}

void CinePlayer::obey(const CineOrder& order, std::int64_t now_ns) {
  using Wish = CineOrder::Wish;
  advance(now_ns);
  if (order.wish == Wish::kSpeed) {
    speed_ = order.speed;
    shown_since_ns_ = now_ns;
  }
  if (!frozen_) return;
  switch (order.wish) {
    case Wish::kPlay:
      if (playing_) return;
      playing_ = count() > 1;
      shown_since_ns_ = now_ns;
      return;
    case Wish::kPause:
      playing_ = false;
      return;
    case Wish::kStep: {
      playing_ = false;
      const auto whole = static_cast<std::int64_t>(count());
      const std::int64_t there = (std::int64_t{volume_} + order.volumes) % whole;
      volume_ = static_cast<std::uint32_t>((there + whole) % whole);
      return;
    }
    case Wish::kSeek:
      return seek(order.volume);
    case Wish::kFreeze:
    case Wish::kLive:
    case Wish::kSpeed:
      return;
  }
}

std::int64_t CinePlayer::shown_for_ns() const {
  const bool last = volume_ + 1 == count();
  const std::int64_t whole_ns = capture_times_ns_.back() - capture_times_ns_.front();
  // The newest volume stays as long as the others do on average.
  const std::int64_t captured_ns = last ? (whole_ns > 0 ? whole_ns / (count() - 1) : kUsualNs)
                                        : capture_times_ns_[volume_ + 1] - capture_times_ns_[volume_];
  const auto shown_ns = static_cast<double>(std::min(kMostNs, captured_ns)) / speed_;
  return std::max(kLeastNs, static_cast<std::int64_t>(shown_ns));
}

void CinePlayer::advance(std::int64_t now_ns) {
  if (!playing_) return;
  // At most one round: a thread that was held up for longer continues from where it is.
  for (std::uint32_t step = 0; step < count(); ++step) {
    const std::int64_t until_ns = shown_since_ns_ + shown_for_ns();
    if (until_ns > now_ns) return;
    shown_since_ns_ = until_ns;
    volume_ = (volume_ + 1) % count();
  }
  shown_since_ns_ = now_ns;
}

std::optional<std::int64_t> CinePlayer::next_change_ns() const {
  if (!playing_) return std::nullopt;
  return shown_since_ns_ + shown_for_ns();
}

CineStatus CinePlayer::status() const {
  if (!frozen_) return {.speed = speed_};
  return {.state = playing_ ? CineStatus::State::kPlaying : CineStatus::State::kFrozen,
          .volumes = count(),
          .volume = volume_,
          .time_s = seconds(capture_times_ns_[volume_] - capture_times_ns_.front()),
          .duration_s = seconds(capture_times_ns_.back() - capture_times_ns_.front()),
          .speed = speed_};
}

}  // namespace fanlight
