// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_outbox.hpp"

namespace fanlight {

bool IgtlOutbox::lost() {
  counters_.igtl_messages_offered.add();
  counters_.igtl_messages_skipped.add();
  return false;
}

bool IgtlOutbox::offer(IgtlStream stream, const IgtlMessage& message, bool key) {
  if (stream == IgtlStream::kFrames) return offer_frame(message);
  if (stream == IgtlStream::kVideo && !can_be_decoded(key)) return lost();
  IgtlMessage& waits = waiting_[static_cast<std::size_t>(stream)];
  if (waits != nullptr) {
    counters_.igtl_messages_skipped.add();
    bytes_of_all_ -= std::exchange(waits, nullptr)->size();
  }
  if (!has_room(message->size())) {
    if (stream == IgtlStream::kVideo) video_lost_ = true;
    return lost();
  }
  waits = message;
  bytes_of_all_ += message->size();
  counters_.igtl_messages_offered.add();
  return true;
}

bool IgtlOutbox::offer_frame(const IgtlMessage& message) {
  if (frame_bytes_ + message->size() > kMostFrameBytes || !has_room(message->size())) return lost();
  frames_.push_back(message);
  frame_bytes_ += message->size();
  bytes_of_all_ += message->size();
  counters_.igtl_messages_offered.add();
  return true;
}

bool IgtlOutbox::can_be_decoded(bool key) {
  const bool one_waits = waiting_[static_cast<std::size_t>(IgtlStream::kVideo)] != nullptr;
  video_lost_ = !key && (video_lost_ || one_waits);
  return !video_lost_;
}

IgtlMessage IgtlOutbox::next() {
  for (std::size_t i = 0; i < kIgtlStreams; ++i) {
    const std::size_t stream = turn_++ % kIgtlStreams;
    const bool frames = stream == static_cast<std::size_t>(IgtlStream::kFrames);
    if (frames ? frames_.empty() : waiting_[stream] == nullptr) continue;
    IgtlMessage message;
    if (frames) {
      message = std::move(frames_.front());
      frames_.pop_front();
      frame_bytes_ -= message->size();
    } else {
      message = std::exchange(waiting_[stream], nullptr);
    }
    bytes_under_way_ = message->size();
    return message;
  }
  return nullptr;
}

void IgtlOutbox::clear() {
  for (IgtlMessage& waits : waiting_) {
    if (waits == nullptr) continue;
    counters_.igtl_messages_skipped.add();
    bytes_of_all_ -= std::exchange(waits, nullptr)->size();
  }
  counters_.igtl_messages_skipped.add(frames_.size());
  frames_.clear();
  bytes_of_all_ -= std::exchange(frame_bytes_, 0);
  video_lost_ = true;
}

}  // namespace fanlight
