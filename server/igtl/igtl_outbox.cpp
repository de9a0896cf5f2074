// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_outbox.hpp"

#include <utility>

namespace fanlight {

bool IgtlOutbox::lost() {
  counters_.igtl_messages_skipped.add();
  return false;
}

bool IgtlOutbox::offer(IgtlStream stream, const IgtlMessage& message, bool key) {
  counters_.igtl_messages_offered.add();
  if (stream == IgtlStream::kFrames) return offer_frame(message);
  if (stream == IgtlStream::kVideo && !can_be_decoded(key)) return lost();
  IgtlMessage& waits = waiting_[static_cast<std::size_t>(stream)];
  if (waits != nullptr) counters_.igtl_messages_skipped.add();
  waits = message;
  return true;
}

bool IgtlOutbox::offer_frame(const IgtlMessage& message) {
  if (frame_bytes_ + message->size() > kMostFrameBytes ||
      frame_bytes_of_all_ + message->size() > kMostFrameBytesOfAll)
    return lost();
  frames_.push_back(message);
  frame_bytes_ += message->size();
  frame_bytes_of_all_ += message->size();
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
    if (!frames) return std::exchange(waiting_[stream], nullptr);
    IgtlMessage frame = std::move(frames_.front());
    frames_.pop_front();
    frame_bytes_ -= frame->size();
    frame_bytes_of_all_ -= frame->size();
    return frame;
  }
  return nullptr;
}

void IgtlOutbox::clear() {
  for (IgtlMessage& waits : waiting_)
    if (std::exchange(waits, nullptr) != nullptr) counters_.igtl_messages_skipped.add();
  counters_.igtl_messages_skipped.add(frames_.size());
  frames_.clear();
  frame_bytes_of_all_ -= std::exchange(frame_bytes_, 0);
}

}  // namespace fanlight
