// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "proto/base/result.hpp"
#include "proto/model/picture_size.hpp"

namespace fanlight {

/// Parses "512x512": width and height in pixels, 16 to 2048 each. Error: kInvalidArgument.
Result<PictureSize> parse_picture_size(std::string_view text);

}  // namespace fanlight
