// SPDX-License-Identifier: Apache-2.0
#include "server/stream/picture_snapshot.hpp"

#include "server/codec/reduced_picture.hpp"
#include "server/stream/picture_message.hpp"

namespace fanlight {

void PictureSnapshot::take(const Picture& picture) {
  depth_packed_ = false;
  picture_.stamp = picture.stamp;
  picture_.width = picture.width;
  picture_.height = picture.height;
  picture_.rgba.assign(picture.rgba.begin(), picture.rgba.end());
  picture_.depth_mm.assign(picture.depth_mm.begin(), picture.depth_mm.end());
  picture_.certainty.assign(picture.certainty.begin(), picture.certainty.end());
}

const std::string& PictureSnapshot::depth(PictureSize size) {
  const std::lock_guard lock(mutex_);
  const bool whole = size == PictureSize{picture_.width, picture_.height};
  if (!depth_packed_)
    depth_ = whole ? packed_depth(picture_.depth_mm) : packed_depth(reduced_depths(picture_, size));
  depth_packed_ = true;  // only after the packing, which may find no memory
  return depth_;
}

}  // namespace fanlight
