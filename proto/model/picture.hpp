// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "proto/model/deadline.hpp"
#include "proto/model/echo_levels.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Stages whose durations each picture carries, in the order of execution.
enum class Stage : std::uint8_t { kPrepare, kUpload, kCast, kFilter, kLight, kFinish, kReadBack };
inline constexpr std::array<std::string_view, 7> kStageNames = {"prepare", "upload", "cast",     "filter",
                                                                "light",   "finish", "read_back"};
inline constexpr std::size_t kStages = kStageNames.size();

/// The part of a picture that shows a surface, in pixels. Only this part has depths.
struct SurfacePart {
  std::uint32_t left = 0;
  std::uint32_t top = 0;
  std::uint32_t width = 0;  ///< 0: the mode shows no surface
  std::uint32_t height = 0;
  bool as_depth = false;      ///< shown as a depth map, not lit
  bool seen_through = false;  ///< shown as glass: depths alone do not make the picture

  bool operator==(const SurfacePart&) const = default;
};

/// Position of a picture's pixels in the transducer frame. The point at depth d of pixel (column, row) is
/// origin + d * forward + (mm_per_pixel + d * mm_per_pixel_per_mm) * ((column - middle_column) * right + (row
/// - middle_row) * down). Depths are measured along forward; right, down and forward are unit vectors.
struct PictureView {
  std::array<double, 3> origin_mm{};
  std::array<double, 3> right{};
  std::array<double, 3> down{};
  std::array<double, 3> forward{};
  double mm_per_pixel = 0;         ///< in the view plane
  double mm_per_pixel_per_mm = 0;  ///< 0 in a parallel projection
  double middle_column = 0;
  double middle_row = 0;
  SurfacePart part;

  bool operator==(const PictureView&) const = default;
};

/// The tissue next to the probe, in a picture (Scene::Near).
enum class NearTissueState : std::uint8_t {
  kShown,
  kRemoved,        ///< up to the first fluid
  kNotFound,       ///< to be removed, but the volume shows no fluid behind it: it is shown
  kRemovedToBone,  ///< up to the near wall of a closed bright shell
  kNoBone,         ///< to be removed, but the volume shows neither such a shell nor fluid: it is shown
};

/// Identity and time of one picture.
struct PictureStamp {
  std::uint64_t view_id = 0;         ///< 0: the main view; else PrivateView::view_id
  std::uint64_t picture_id = 0;      ///< counts the pictures of a view from 1
  std::uint64_t scene_revision = 0;  ///< of the scene shown
  std::uint64_t pass1_runs = 0;      ///< count of the renderer when this picture was submitted
  std::uint64_t pass2_runs = 0;
  /// Of the filtered depth map, unique in the process: pictures of which only the light differs share it.
  std::uint64_t surface_id = 0;
  std::uint8_t deadline_level = 0;  ///< see DeadlineState
  DeadlineMeasures measures;        ///< in force for this picture
  VolumeStamp volume;
  EchoLevels levels;  ///< in force for this picture, where its scene asks for values from the data
  NearTissueState near_tissue = NearTissueState::kShown;
  /// Depth (y) at which the removed near tissue ends, on the line along y through the camera's target; NaN:
  /// it is shown, or that line does not meet it.
  double near_end_mm = std::numeric_limits<double>::quiet_NaN();
  Point sample_distances;    ///< FanGeometry::sample_distances() at the camera's target
  double surface_share = 0;  ///< of the pixels, those with a surface, 0 to 1
  /// Of these, those whose surface is uncertain and dimmed, 0 to 1: it stands out from the speckle by
  /// little, fills a hole, or is seen from where no beam came. 0 in modes that do not light the surface.
  double uncertain_share = 0;
  /// Of the pixels with a surface, the share whose depth is a mean over volumes (Scene::Filter::steady), 0 to
  /// 1; and the mean number of these volumes, 1 without such pixels.
  double steady_share = 0;
  double mean_volumes = 1;
  /// Refresh::kFrame: the number of frames over which the surface of the last sweep is blended into the new
  /// one (Scene::Filter::seam_frames); 0: nothing is blended.
  int seam_frames = 0;
  PictureView view;
  std::array<double, kStages> stage_ms{};  ///< 0 where the stage did not run for this picture
  bool passes_overlap = false;             ///< passes 2 and 3 run while pass 1 of another volume does
  std::int64_t finished_time_ns = 0;       ///< fanlight::now_ns
};

/// A finished picture. `rgba`: height x width x 4 bytes, row major, top row first, sRGB values, alpha 255.
/// `depth_mm`: height x width floats, same order, depth of the surface as lit; negative: no surface.
/// `certainty`: height x width, same order: 0 where no ray met a surface, else how certain it is, 1 to 255
/// (shaders/certainty.h). Holes that the filter has filled have a depth and no certainty.
struct Picture {
  PictureStamp stamp;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgba;
  std::vector<float> depth_mm;
  std::vector<std::uint8_t> certainty;
};

/// A black picture with all the memory that it will need, so that filling it allocates nothing.
inline Picture blank_picture(std::uint32_t width, std::uint32_t height) {
  Picture blank{.width = width, .height = height};
  blank.rgba.resize(std::size_t{4} * width * height);
  blank.depth_mm.resize(std::size_t{width} * height);
  blank.certainty.resize(std::size_t{width} * height);
  return blank;
}

/// Reserves memory for a picture of that size. It costs nothing until it is used.
inline void reserve_picture(Picture& picture, PictureSize largest) {
  picture.rgba.reserve(4 * largest.pixels());
  picture.depth_mm.reserve(largest.pixels());
  picture.certainty.reserve(largest.pixels());
}

}  // namespace fanlight
