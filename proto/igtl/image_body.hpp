// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace fanlight::igtl {

/// How an IMAGE stores a number.
enum class ScalarType : std::uint8_t {
  kInt8 = 2,
  kUint8 = 3,
  kInt16 = 4,
  kUint16 = 5,
  kInt32 = 6,
  kUint32 = 7,
  kFloat32 = 10,
  kFloat64 = 11,
};
/// 0 for a number that is none of them.
std::size_t bytes_of(ScalarType type);

/// Position of a grid in space, mm, in the axes that 3D Slicer uses: R to the right of the patient, A to the
/// front, S to the head. Where nothing is known of a patient, they are the axes of whatever the sender names.
struct GridPose {
  std::array<double, 3> i_mm{1, 0, 0};  ///< from a pixel to the next along i; its length is the pixel's size
  std::array<double, 3> j_mm{0, 1, 0};
  std::array<double, 3> k_mm{0, 0, 1};
  std::array<double, 3> first_mm{};  ///< centre of pixel (0, 0, 0)
};

/// The twelve numbers of a matrix in the network: what leads to the next pixel along i, j and k, and the
/// position of the centre of a grid of this size, (size - 1) / 2; see GridPose::first_mm.
std::array<float, 12> grid_matrix(const std::array<std::uint16_t, 3>& size, const GridPose& pose);

/// Content of an IMAGE message: 72 bytes of header, and the pixels of the part that it carries, i fastest,
/// the numbers of a pixel together.
struct ImageBody {
  std::uint8_t components = 1;
  ScalarType scalar = ScalarType::kUint8;
  bool big_endian = false;              ///< of the pixels
  std::array<std::uint16_t, 3> size{};  ///< pixels of the whole image along i, j, k
  GridPose pose;
  std::array<std::uint16_t, 3> part_offset{};  ///< first pixel of the part, and its size
  std::array<std::uint16_t, 3> part_size{};

  bool is_whole() const { return part_size == size; }
  std::uint64_t part_bytes() const {
    return std::uint64_t{part_size[0]} * part_size[1] * part_size[2] * components * bytes_of(scalar);
  }
};

inline constexpr std::size_t kImageHeaderBytes = 72;

/// An image and its pixels, which refer to the message.
struct ReceivedImage {
  ImageBody body;
  std::span<const std::uint8_t> pixels;
};

/// nullopt: the content is no IMAGE: another version, an unknown type, a part beyond the image, a matrix that
/// is no number, or another length than the header announces. LPS is turned to RAS.
std::optional<ReceivedImage> parse_image(std::span<const std::uint8_t> content);

/// Appends the header in RAS. The pixels of the part follow it.
void put_image_header(std::vector<std::uint8_t>& bytes, const ImageBody& image);

}  // namespace fanlight::igtl
