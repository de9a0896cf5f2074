// SPDX-License-Identifier: Apache-2.0
#include "server/stream/picture_snapshot.hpp"

#include <utility>

#include "server/stream/picture_message.hpp"

namespace fanlight {

void PictureSnapshot::take(const Picture& picture) {
  picture_.stamp = picture.stamp;
  picture_.width = picture.width;
  picture_.height = picture.height;
  picture_.rgba.assign(picture.rgba.begin(), picture.rgba.end());
  picture_.depth_mm.assign(picture.depth_mm.begin(), picture.depth_mm.end());
  depth_packed_ = false;
}

const std::string& PictureSnapshot::depth() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(depth_packed_, true)) depth_ = packed_depth(picture_);
  return depth_;
}

}  // namespace fanlight
