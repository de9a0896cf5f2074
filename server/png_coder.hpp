#pragma once

#include <vector>

#include "server/picture_coder.hpp"

namespace fanlight {

/// PNG through libpng, at its fastest.
class PngCoder : public PictureCoder {
 public:
  Result<CodedPicture> encode(const Pixels& pixels, bool key) override;

 private:
  std::vector<std::uint8_t> png_;
};

}  // namespace fanlight
