// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "proto/base/fixed_text.hpp"

namespace fanlight::igtl {

/// Port that 3D Slicer and PlusServer use.
inline constexpr std::uint16_t kUsualPort = 18944;

inline constexpr std::size_t kHeadBytes = 58;
inline constexpr std::size_t kTypeLength = 12;
inline constexpr std::size_t kNameLength = 20;
using TypeName = FixedText<kTypeLength>;
using DeviceName = FixedText<kNameLength>;

/// What precedes the body of every OpenIGTLink message (OpenIGTLink, Documents/Protocol/header.md).
struct MessageHead {
  std::uint16_t version = 1;  ///< 1; or 2 and 3: the body begins with an extended header (open_message())
  TypeName type;              ///< "IMAGE", "GET_IMAGE", ...
  DeviceName device;
  std::uint64_t timestamp = 0;  ///< see Timestamp; 0: none
  std::uint64_t body_bytes = 0;
  std::uint64_t crc = 0;  ///< crc64() of the body
};

/// nullopt: these bytes are no head: a version other than 1 to 3, or a type that is no printable ASCII text.
/// A stream has no other mark by which a lost place could be noticed.
std::optional<MessageHead> parse_head(std::span<const std::uint8_t, kHeadBytes> bytes);

void write_head(std::span<std::uint8_t, kHeadBytes> bytes, const MessageHead& head);

/// What a query asks for.
enum class Query : std::uint8_t {
  kNone,   ///< a message that is no query
  kGet,    ///< one message
  kStart,  ///< a message each time that there is a new one
  kStop,
  kReply,  ///< the answer to the others
};

/// The prefix of a type, and the type without it: "STT_TDATA" is kStart of "TDATA". CAPABILITY is named
/// CAPABIL in queries, and here too: 12 characters hold no more.
struct QueryType {
  Query query = Query::kNone;
  std::string_view type;
};
QueryType query_of(std::string_view type);

}  // namespace fanlight::igtl
