// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "proto/igtl/message_head.hpp"
#include "proto/igtl/metadata.hpp"

namespace fanlight::igtl {

/// The parts of a message's body. They refer to the bytes of the body.
struct OpenedMessage {
  enum class State : std::uint8_t {
    kGood,
    kDamaged,    ///< its checksum is wrong
    kMalformed,  ///< its extended header contradicts its length, or itself
  };
  State state = State::kGood;             ///< else there is no content
  std::span<const std::uint8_t> content;  ///< without extended header and metadata
  std::uint32_t message_id = 0;           ///< of version 2 and 3; else 0
  Metadata metadata;
};

/// Checks a body against its head and divides it. Version 2 and 3: 12 bytes of extended header (its own
/// length, the lengths of the metadata's index and texts, the message's id) and what else its length covers;
/// the content; the number of metadata items, their index, their texts. Allocates nothing.
OpenedMessage open_message(const MessageHead& head, std::span<const std::uint8_t> body);

}  // namespace fanlight::igtl
