// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/igtl/message_head.hpp"

namespace fanlight::igtl {

/// Finds the messages in a stream of bytes. The caller writes what it receives into room() and says how much
/// that was. Memory grows with the longest message so far, up to a limit. One thread.
class MessageReader {
 public:
  enum class Event : std::uint8_t {
    kMore,      ///< the message is not whole yet
    kMessage,   ///< head() and body() are whole; the body is valid until the next call of room()
    kSkipped,   ///< head() and a body over the limit, of which nothing was kept, are past
    kLost,      ///< these bytes are no head: the place in the stream is lost, and the stream of no more use
    kUnwanted,  ///< head() announces a body that nothing of this protocol has: as kLost
  };

  /// A body of over `most_body_bytes` is skipped. One of over `most_skipped_bytes` is kUnwanted: a length
  /// that lies would otherwise swallow all that follows.
  MessageReader(std::uint64_t most_body_bytes, std::uint64_t most_skipped_bytes)
      : most_body_bytes_(most_body_bytes), most_skipped_bytes_(most_skipped_bytes) {}

  /// Where the next bytes go; never empty.
  std::span<std::uint8_t> room();
  /// The first `bytes` of room() were filled. Precondition: 1 to room().size().
  Event filled(std::size_t bytes);

  /// Some bytes of a head came, and not all of them.
  bool is_in_head() const { return !in_body_ && have_ > 0; }

  const MessageHead& head() const { return head_; }
  std::span<const std::uint8_t> body() const { return {body_.data(), head_.body_bytes}; }
  /// Exchanges the memory of the body. Call it after kMessage; the message is then in `memory`.
  void swap_body(std::vector<std::uint8_t>& memory) { body_.swap(memory); }

  /// The next byte begins a message: another connection.
  void restart() { *this = MessageReader(most_body_bytes_, most_skipped_bytes_, std::move(body_)); }

 private:
  MessageReader(std::uint64_t most_body_bytes, std::uint64_t most_skipped_bytes,
                std::vector<std::uint8_t> memory)
      : most_body_bytes_(most_body_bytes),
        most_skipped_bytes_(most_skipped_bytes),
        body_(std::move(memory)) {}
  bool skips() const { return head_.body_bytes > most_body_bytes_; }
  Event begin_body();

  std::uint64_t most_body_bytes_;
  std::uint64_t most_skipped_bytes_;
  std::array<std::uint8_t, kHeadBytes> head_bytes_{};
  MessageHead head_;
  bool in_body_ = false;
  std::uint64_t have_ = 0;  // bytes of the head, or of the body
  std::vector<std::uint8_t> body_;
};

}  // namespace fanlight::igtl
