// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "proto/igtl/message_head.hpp"
#include "proto/igtl/metadata.hpp"

namespace fanlight::igtl {

/// Version 1 is understood by every program. Version 2 carries metadata and a message's id.
enum class HeadVersion : std::uint16_t { kOne = 1, kTwo = 2 };

/// Of a message to write.
struct Envelope {
  TypeName type;
  DeviceName device;
  std::uint64_t timestamp = 0;
  HeadVersion version = HeadVersion::kOne;
  std::uint32_t message_id = 0;  ///< with version 2
  MetadataItems metadata{};      ///< with version 2; left out in version 1
};

/// Writes messages into memory that it keeps: head, extended header, content, metadata. One thread.
class MessageWriter {
 public:
  /// Begins a message. Append its content to the result, then call finish().
  std::vector<std::uint8_t>& begin(const Envelope& envelope);
  /// Appends the metadata and fills in lengths and checksum. The message is valid until begin().
  std::span<const std::uint8_t> finish();

 private:
  std::vector<std::uint8_t> bytes_;
  MessageHead head_;
  std::vector<std::uint8_t> index_;
  std::vector<std::uint8_t> texts_;
};

}  // namespace fanlight::igtl
