#include "server/picture_encoder.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

namespace fanlight {

void PictureEncoder::Release::operator()(void* handle) const {
  tjDestroy(handle);
}

PictureEncoder::PictureEncoder(int quality) : handle_(tjInitCompress()), quality_(quality) {}

Result<std::span<const std::uint8_t>> PictureEncoder::encode(const Picture& picture) {
  if (handle_ == nullptr)
    return Error{ErrorCode::kUnavailable, "the JPEG encoder could not be made, expected memory for it"};
  const int width = static_cast<int>(picture.width);
  const int height = static_cast<int>(picture.height);
  jpeg_.resize(tjBufSize(width, height, TJSAMP_444));
  unsigned char* target = jpeg_.data();
  unsigned long bytes = jpeg_.size();
  const int failed = tjCompress2(handle_.get(), picture.rgba.data(), width, 0, height, TJPF_RGBX, &target,
                                 &bytes, TJSAMP_444, quality_, TJFLAG_NOREALLOC);
  if (failed != 0) {
    return Error{ErrorCode::kBroken, fmt::format("encoding a picture of {} x {} failed: {}", width, height,
                                                 tjGetErrorStr2(handle_.get()))};
  }
  return std::span<const std::uint8_t>(jpeg_.data(), bytes);
}

}  // namespace fanlight
