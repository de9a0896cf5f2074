// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "proto/model/picture_size.hpp"
#include "server/codec/stream_settings.hpp"

namespace fanlight {

/// The settings with the size in which the pixels of a picture are sent, `usual` where they give none. Pixels
/// beside a surface are sent as they are.
StreamSettings with_size(StreamSettings settings, std::optional<PictureSize> usual);

/// Makes room in `wanted` for a display with these settings. What is smaller than `usual` is reduced when it
/// is sent.
void widen(WantedSizes& wanted, const StreamSettings& settings, PictureSize usual);

}  // namespace fanlight
