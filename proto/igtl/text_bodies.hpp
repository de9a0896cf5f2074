// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "proto/base/fixed_text.hpp"
#include "proto/igtl/message_head.hpp"

namespace fanlight::igtl {

/// Codes of a STATUS message (OpenIGTLink, Documents/Protocol/status.md); others are possible.
enum class StatusCode : std::uint16_t {
  kOk = 1,
  kUnknownError = 2,
  kNotFound = 4,
  kAccessDenied = 5,
  kBusy = 6,
  kTimeOut = 7,
  kBadConfiguration = 10,
  kNoResources = 11,
  kUnknownInstruction = 12,
  kNotReady = 13,
  kShuttingDown = 19,
};

struct StatusBody {
  StatusCode code = StatusCode::kOk;
  std::int64_t sub_code = 0;
  FixedText<20> name;  ///< of the error
  std::string_view text;
};
/// nullopt: too short. The text refers to the content.
std::optional<StatusBody> parse_status(std::span<const std::uint8_t> content);
void put_status(std::vector<std::uint8_t>& bytes, const StatusBody& status);

/// nullopt: another length than it says. The text refers to the content.
std::optional<std::string_view> parse_string(std::span<const std::uint8_t> content);
void put_string(std::vector<std::uint8_t>& bytes, std::string_view text);

/// A command in XML, or its answer.
struct CommandBody {
  std::uint32_t id = 0;
  FixedText<128> name;
  std::string_view text;
};
/// nullopt: another length than it says. The text refers to the content.
std::optional<CommandBody> parse_command(std::span<const std::uint8_t> content);
void put_command(std::vector<std::uint8_t>& bytes, const CommandBody& command);

/// The types that a program understands, in a CAPABILITY message.
void put_capability(std::vector<std::uint8_t>& bytes, std::span<const TypeName> types);
/// In order; empty for a content of another length.
std::vector<TypeName> parse_capability(std::span<const std::uint8_t> content);

}  // namespace fanlight::igtl
