// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace fanlight {

struct Pixels;

/// What is written into a picture for viewers that show nothing beside it, such as an <img>.
enum class PictureMark : std::uint8_t { kNone, kNotLive, kDelayed, kFrozen, kReplay, kSimulated };

/// "NOT LIVE", "DELAYED", "FROZEN", "REPLAY", "SIMULATED"; empty for kNone.
std::string_view mark_words(PictureMark mark);

/// Writes marks into copies of pictures. Keeps the memory of the last one.
class PictureMarker {
 public:
  /// The words on a coloured field in the upper left corner, about a tenth of the height; a bar of that
  /// colour where the picture is too narrow for them. Valid until the next call, or as long as `pixels` for
  /// kNone.
  Pixels marked(const Pixels& pixels, PictureMark mark);

 private:
  std::vector<std::uint8_t> rgba_;
};

}  // namespace fanlight
