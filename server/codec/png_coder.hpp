// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "server/codec/picture_coder.hpp"

namespace fanlight {

/// Encodes PNG with libpng and its fastest compression.
class PngCoder : public PictureCoder {
 public:
  Result<CodedPicture> encode(const Pixels& pixels, bool key) override;

 private:
  std::vector<std::uint8_t> png_;
};

}  // namespace fanlight
