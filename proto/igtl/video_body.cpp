// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/video_body.hpp"

#include <bit>
#include <string_view>

#include "proto/igtl/big_endian.hpp"

namespace fanlight::igtl {

void put_video_header(std::vector<std::uint8_t>& bytes, const std::array<std::uint16_t, 3>& size,
                      const GridPose& pose, VideoFrame frame) {
  constexpr std::uint16_t kVersion = 1;
  constexpr std::uint8_t kLittleEndian = 2;
  constexpr std::string_view kCodec = "H264";
  constexpr std::uint8_t kRas = 1;
  put_big_endian(bytes, kVersion);
  bytes.push_back(kLittleEndian);
  bytes.insert(bytes.end(), kCodec.begin(), kCodec.end());
  put_big_endian(bytes, static_cast<std::uint16_t>(frame));
  bytes.push_back(kRas);
  for (const std::uint16_t side : size) put_big_endian(bytes, side);
  for (const float number : grid_matrix(size, pose))
    put_big_endian(bytes, std::bit_cast<std::uint32_t>(number));
  for (int axis = 0; axis < 3; ++axis) put_big_endian(bytes, std::uint16_t{0});  // the part's first pixel
  for (const std::uint16_t side : size) put_big_endian(bytes, side);
}

}  // namespace fanlight::igtl
