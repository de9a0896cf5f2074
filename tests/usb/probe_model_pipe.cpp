// SPDX-License-Identifier: Apache-2.0
// Bulk pipe of ProbeModel: frames and faults to bytes of transfers.

#include <algorithm>
#include <utility>

#include "tests/usb/probe_model.hpp"

namespace fanlight::test {

namespace {

constexpr std::size_t kPacketBytes = 512;       // of a high speed bulk endpoint
constexpr std::size_t kDamagedHeaderByte = 20;  // in the device time; the magic number stays valid

}  // namespace

ProbeModel::Filled ProbeModel::fill(std::span<std::uint8_t> to, std::int64_t now_ns) {
  advance(now_ns);
  last_fate_.reset();
  Filled filled;
  if (now_ns < silent_until_ns_) return filled;
  if (std::exchange(owes_empty_packet_, false)) return {.ended = true};
  while (filled.bytes < to.size() && !filled.ended) {
    if (!under_way_ && !begin_next()) break;
    filled.bytes += copy_under_way(to.subspan(filled.bytes));
    if (under_way_->sent_bytes < under_way_->size()) break;

    const bool last_packet_full = under_way_->size() % kPacketBytes == 0;
    if (under_way_->ends_transfer) {
      filled.ended = !last_packet_full || filled.bytes < to.size();
      owes_empty_packet_ = !filled.ended;
    }
    settle(under_way_->fate);
    if (owes_empty_packet_) break;
  }
  return filled;
}

std::size_t ProbeModel::copy_under_way(std::span<std::uint8_t> to) {
  UnderWay& frame = *under_way_;
  std::size_t copied = 0;
  if (frame.sent_bytes < frame.front.size()) {
    copied = std::min(to.size(), frame.front.size() - frame.sent_bytes);
    std::copy_n(frame.front.begin() + static_cast<std::ptrdiff_t>(frame.sent_bytes), copied, to.begin());
    frame.sent_bytes += copied;
  }
  if (frame.sent_bytes >= frame.front.size()) {
    const auto left = frame.pixels.subspan(frame.sent_bytes - frame.front.size());
    const std::size_t count = std::min(to.size() - copied, left.size());
    std::copy_n(left.begin(), count, to.begin() + static_cast<std::ptrdiff_t>(copied));
    frame.sent_bytes += count;
    copied += count;
  }
  counters_.bytes += copied;
  return copied;
}

/// The frame being sent has ended. It is sent again for the fault repeat.
void ProbeModel::settle(Fate fate) {
  switch (fate) {
    case Fate::kSent:
      ++counters_.frames_sent;
      break;
    case Fate::kTorn:
      ++counters_.frames_torn;
      break;
    case Fate::kWithheld:
      break;  // counted when it reached the pipe
    case Fate::kRepeat:
      ++counters_.repeats;
      break;
  }
  last_fate_ = fate;
  if (fate != Fate::kSent || !under_way_->repeat) {
    under_way_.reset();
    return;
  }
  UnderWay& again = *under_way_;
  again.front.erase(again.front.begin(),
                    again.front.begin() + static_cast<std::ptrdiff_t>(again.noise_bytes));
  again.noise_bytes = 0;
  again.sent_bytes = 0;
  again.repeat = false;
  again.fate = Fate::kRepeat;
}

void ProbeModel::lose_last_fill() {
  if (last_fate_ == Fate::kSent) {
    --counters_.frames_sent;
    ++counters_.frames_torn;
    last_fate_ = Fate::kTorn;
  } else if (under_way_ && under_way_->sent_bytes > 0 && under_way_->fate == Fate::kSent) {
    under_way_->fate = Fate::kTorn;
  }
}

void ProbeModel::tear() {
  owes_empty_packet_ = false;
  if (!under_way_) return;
  under_way_->repeat = false;
  switch (under_way_->fate) {
    case Fate::kSent:
    case Fate::kTorn:
      settle(Fate::kTorn);
      break;
    case Fate::kWithheld:
    case Fate::kRepeat:
      under_way_.reset();
      break;  // counted, or never whole
  }
}

bool ProbeModel::begin_next() {
  if (held_ && successor_sent_) {
    under_way_ = std::exchange(held_, std::nullopt);
    return true;
  }
  while (!queue_.empty()) {
    const Taken next = std::move(queue_.front());
    queue_.pop_front();
    ++frames_offered_;
    if (std::exchange(pending_.drop, false)) {
      ++counters_.frames_withheld;
      continue;
    }
    if (random_) {
      ++counters_.frames_withheld;
      under_way_ = random_bytes(probe::kFrameHeaderBytes + next.header.payload_bytes);
      return true;
    }
    const bool hold = std::exchange(pending_.swap, false) && !held_;
    UnderWay frame = drawn(next);
    if (!hold) {
      under_way_ = std::move(frame);
      successor_sent_ = true;
      return true;
    }
    hold_back(std::move(frame));
  }
  return false;
}

void ProbeModel::hold_back(UnderWay frame) {
  // The picture's memory is overwritten by the next one.
  frame.own_pixels.assign(frame.pixels.begin(), frame.pixels.end());
  frame.pixels = frame.own_pixels;
  held_ = std::move(frame);
  successor_sent_ = false;
  ++counters_.swaps;
}

/// The frame, modified by the pending faults.
ProbeModel::UnderWay ProbeModel::drawn(const Taken& frame) {
  const ProbePictures::Picture picture = frame.pictures->show(frame.picture, frame.rows);
  const Pending faults = std::exchange(pending_, Pending{});
  probe::FrameHeader header = frame.header;
  header.payload_crc32c = picture.crc32c;
  header.invalid = faults.invalid;
  if (faults.misfit) header.geometry_revision += 1000;

  UnderWay made{.pixels = picture.pixels, .pictures = frame.pictures, .repeat = faults.repeat};
  made.ends_transfer = config_.ends_transfers || faults.cut;
  put_noise(made.front, faults.noise_bytes);
  made.noise_bytes = made.front.size();
  const auto block = encode(header);
  made.front.insert(made.front.end(), block.begin(), block.end());

  counters_.invalid += faults.invalid ? 1 : 0;
  if (faults.damage_header) {
    made.front[made.noise_bytes + kDamagedHeaderByte] ^= 1;
    ++counters_.damaged_headers;
  }
  if (faults.damage) {
    made.own_pixels.assign(picture.pixels.begin(), picture.pixels.end());
    made.own_pixels[made.own_pixels.size() / 2] ^= 1;
    made.pixels = made.own_pixels;
    ++counters_.damaged;
  }
  if (faults.cut) {
    made.pixels = made.pixels.first(made.pixels.size() / 2);
    made.fate = Fate::kTorn;
  }
  return made;
}

ProbeModel::UnderWay ProbeModel::random_bytes(std::size_t bytes) {
  UnderWay made{.ends_transfer = false, .fate = Fate::kWithheld};
  put_noise(made.front, bytes);
  return made;
}

void ProbeModel::put_noise(std::vector<std::uint8_t>& to, std::size_t bytes) {
  to.resize(bytes);
  std::ranges::generate(to, [this] { return static_cast<std::uint8_t>(noise_()); });
  counters_.noise_bytes += bytes;
}

void ProbeModel::inject(const Fault& fault, std::int64_t now_ns) {
  // Frames due before the fault are captured before it.
  advance(now_ns);
  switch (fault.kind) {
    case FaultKind::kDrop:
      pending_.drop = true;
      break;
    case FaultKind::kInvalid:
      pending_.invalid = true;
      break;
    case FaultKind::kMisfit:
      pending_.misfit = true;
      break;
    case FaultKind::kDamage:
      pending_.damage = true;
      break;
    case FaultKind::kDamageHeader:
      pending_.damage_header = true;
      break;
    case FaultKind::kCut:
      pending_.cut = true;
      break;
    case FaultKind::kRepeat:
      pending_.repeat = true;
      break;
    case FaultKind::kSwap:
      pending_.swap = true;
      break;
    case FaultKind::kNoise:
      pending_.noise_bytes += fault.bytes;
      break;
    case FaultKind::kGeometry:
      change_depth(active_rows_ == config_.rows ? config_.rows * 3 / 4 : config_.rows);
      set_.depth_mm = active_.depth_mm;
      break;
    case FaultKind::kRestart:
      begin_first_sweep();
      break;
    case FaultKind::kSilent:
      silent_until_ns_ = now_ns + fault.duration_ns;
      break;
    case FaultKind::kRandom:
      random_ = true;
      break;
    case FaultKind::kStall:
    case FaultKind::kError:
    case FaultKind::kOverflow:
    case FaultKind::kLateIdentity:
    case FaultKind::kMute:
    case FaultKind::kUnplug:
    case FaultKind::kReplug:
      break;
  }
}

}  // namespace fanlight::test
