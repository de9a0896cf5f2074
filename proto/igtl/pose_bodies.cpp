// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/pose_bodies.hpp"

#include <openigtlink/igtl_tdata.h>
#include <openigtlink/igtl_transform.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace fanlight::igtl {

namespace {

using Vector = std::array<double, 3>;
constexpr std::size_t kNumbers = 12;
static_assert(sizeof(igtl_tdata_element) == kToolBytes);
static_assert(sizeof(float) * kNumbers == kTransformBytes);

std::optional<GridPose> pose_of(const float* numbers) {
  if (!std::all_of(numbers, numbers + kNumbers, [](float each) { return std::isfinite(each); }))
    return std::nullopt;
  const auto column = [numbers](std::size_t at) {
    return Vector{numbers[3 * at], numbers[3 * at + 1], numbers[3 * at + 2]};
  };
  return GridPose{column(0), column(1), column(2), column(3)};
}

Vector turned(const GridPose& pose, const Vector& vector) {
  Vector result{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    result[axis] = pose.i_mm[axis] * vector[0] + pose.j_mm[axis] * vector[1] + pose.k_mm[axis] * vector[2];
  return result;
}

}  // namespace

std::optional<GridPose> parse_transform(std::span<const std::uint8_t> content) {
  if (content.size() != kTransformBytes) return std::nullopt;
  igtl_float32 numbers[kNumbers];
  std::memcpy(numbers, content.data(), kTransformBytes);
  igtl_transform_convert_byte_order(numbers);
  return pose_of(numbers);
}

void put_transform(std::vector<std::uint8_t>& bytes, const GridPose& pose) {
  igtl_float32 numbers[kNumbers];
  float* next = numbers;
  for (const Vector& column : {pose.i_mm, pose.j_mm, pose.k_mm, pose.first_mm})
    for (const double number : column) *next++ = static_cast<float>(number);
  igtl_transform_convert_byte_order(numbers);
  const auto* const raw = reinterpret_cast<const std::uint8_t*>(numbers);
  bytes.insert(bytes.end(), raw, raw + kTransformBytes);
}

std::optional<TrackedTool> parse_tool(std::span<const std::uint8_t> content, std::size_t index) {
  igtl_tdata_element packed;
  std::memcpy(&packed, content.data() + index * kToolBytes, kToolBytes);
  igtl_tdata_convert_byte_order(&packed, 1);
  std::array<float, kNumbers> numbers{};
  std::memcpy(numbers.data(), packed.transform, kTransformBytes);
  const auto pose = pose_of(numbers.data());
  if (!pose) return std::nullopt;
  return TrackedTool{DeviceName(std::span<const char, kNameLength>(packed.name)), *pose};
}

void put_start_of_tools(std::vector<std::uint8_t>& bytes, std::uint32_t least_ms) {
  igtl_stt_tdata packed{};
  packed.resolution = static_cast<igtl_int32>(least_ms);
  igtl_stt_tdata_convert_byte_order(&packed);
  const auto* const raw = reinterpret_cast<const std::uint8_t*>(&packed);
  bytes.insert(bytes.end(), raw, raw + sizeof(packed));
}

GridPose composed(const GridPose& outer, const GridPose& inner) {
  GridPose result{turned(outer, inner.i_mm), turned(outer, inner.j_mm), turned(outer, inner.k_mm),
                  turned(outer, inner.first_mm)};
  for (std::size_t axis = 0; axis < 3; ++axis) result.first_mm[axis] += outer.first_mm[axis];
  return result;
}

}  // namespace fanlight::igtl
