// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/picture.hpp"

namespace fanlight {

/// The step in which depths are sent: a twelfth of a pixel, so that the slopes of finer pixels are as exact,
/// within these bounds; larger only where the deepest surface lies beyond 65534 such steps.
inline constexpr double kFinestUnitMm = 0.005;
inline constexpr double kCoarsestUnitMm = 0.02;
double surface_unit_mm(const PictureView& view, double deepest_mm);

/// Steps of a certainty from 0 to 1 as it is sent.
inline constexpr int kSentCertainties = 15;

/// Packs the surface of a picture, as proto/DISPLAY_PROTOCOL.md describes: each depth is predicted from its
/// neighbours as on a plane, and zlib codes the differences by Huffman codes alone (server/RESULTS.md
/// compares it with other ways). Keeps its memory. One thread.
class SurfaceCoder {
 public:
  /// Writes all fields of the message. Precondition: picture.stamp.view.part is not empty, and lies within
  /// the picture. Errors: kBroken, the picture has no depths; kUnavailable, zlib has no memory.
  Result<void> encode(const Picture& picture, v1::Surface& to);

 private:
  void pack_row(std::span<const float> depths_mm, double unit_mm);
  void pack_certainties(const Picture& picture);
  void end_run();

  // A row of the part, and the row above it, with a place before the first column and one behind the last.
  struct Row {
    std::vector<std::uint16_t> depths;      // those before them where there is no surface
    std::vector<std::uint8_t> differences;  // at most kMostActivity
  };
  Row row_;
  Row above_;
  bool in_surface_ = false;
  std::uint32_t run_ = 0;
  std::vector<std::uint8_t> runs_;
  std::vector<std::uint8_t> calm_;
  std::vector<std::uint8_t> rough_;
  std::vector<std::uint8_t> large_;
  std::vector<std::uint8_t> certainties_;
};

}  // namespace fanlight
