// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "server/api/operations.hpp"
#include "server/codec/stream_settings.hpp"

namespace fanlight {

/// The decoded parameters of a query, by name.
using ApiQuery = std::map<std::string, std::string, std::less<>>;

/// Reads "?size=320x320&quality=80" of a request's target. Errors, kInvalidArgument: a parameter that is not
/// in `known`, or comes twice, or a text that is no query.
Result<ApiQuery> parse_query(std::string_view target, std::span<const QueryParameter> known);

/// The revision of the scene that a picture must show; 0: any. Error, kInvalidArgument.
Result<std::uint64_t> wanted_revision(const ApiQuery& query);

/// The settings of JPEG pictures: size, quality and rate. Error, kInvalidArgument: the parameter and its
/// range.
Result<StreamSettings> jpeg_settings(const ApiQuery& query, int default_quality);

}  // namespace fanlight
