// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/message_reader.hpp"

#include <algorithm>

namespace fanlight::igtl {

namespace {
constexpr std::size_t kLeastMemory = 64 * 1024;
}

std::span<std::uint8_t> MessageReader::room() {
  if (!in_body_) return std::span(head_bytes_).subspan(have_);
  const std::uint64_t left = head_.body_bytes - have_;
  if (skips()) return std::span(body_).first(std::min<std::uint64_t>(left, body_.size()));
  return {body_.data() + have_, left};
}

MessageReader::Event MessageReader::filled(std::size_t bytes) {
  have_ += bytes;
  if (!in_body_) {
    if (have_ < kHeadBytes) return Event::kMore;
    const auto head = parse_head(head_bytes_);
    if (!head) return Event::kLost;
    head_ = *head;
    return begin_body();
  }
  if (have_ < head_.body_bytes) return Event::kMore;
  in_body_ = false;
  have_ = 0;
  return skips() ? Event::kSkipped : Event::kMessage;
}

MessageReader::Event MessageReader::begin_body() {
  have_ = 0;
  if (head_.body_bytes > std::max(most_body_bytes_, most_skipped_bytes_)) return Event::kUnwanted;
  const std::uint64_t needed = skips() ? kLeastMemory : head_.body_bytes;
  if (body_.size() < needed) body_.resize(std::max<std::uint64_t>(needed, kLeastMemory));
  if (head_.body_bytes == 0) return Event::kMessage;
  in_body_ = true;
  return Event::kMore;
}

}  // namespace fanlight::igtl
