// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <string>

#include "proto/model/picture.hpp"

namespace fanlight {

/// A copy of a picture for the threads that encode it, with its compressed depth map, which is made once for
/// all encodings that carry it.
class PictureSnapshot {
 public:
  /// Copies the picture; the memory is used again. Precondition: no other thread uses this object.
  void take(const Picture& picture);

  const Picture& picture() const { return picture_; }

  /// packed_depth() of the picture in that size. Any thread; the first call compresses, others wait for it.
  /// All calls have the same size.
  const std::string& depth(PictureSize size);

 private:
  Picture picture_;
  std::mutex mutex_;  // of the next two
  bool depth_packed_ = false;
  std::string depth_;
};

}  // namespace fanlight
