#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "proto/scene.hpp"
#include "proto/volume.hpp"

namespace fanlight {

/// The stages whose time each picture carries, in the order in which they run.
enum class Stage : std::uint8_t { kPrepare, kUpload, kCast, kFilter, kLight, kFinish, kReadBack };
inline constexpr std::array<std::string_view, 7> kStageNames = {"prepare", "upload", "cast",     "filter",
                                                                "light",   "finish", "read_back"};
inline constexpr std::size_t kStages = kStageNames.size();

/// What the plan of a scene (deadline.plan) takes from a picture so that their rate holds.
struct DeadlineMeasures {
  bool coarse = false;         ///< a ray for 2 x 2 pixels
  bool wide_step = false;      ///< samples twice as far apart
  bool cheap_filters = false;  ///< no speckle filter; a moving mean of depths, islands and holes left alone

  bool operator==(const DeadlineMeasures&) const = default;
};

/// How far the plan has come, 0 to kMostDeadlineLevel, and what it takes at this moment.
struct DeadlineState {
  std::uint8_t level = 0;
  DeadlineMeasures measures;

  bool operator==(const DeadlineState&) const = default;
};

/// 1: coarse while the view moves; 2: always; 3: and a wide step; 4: and cheap filters.
inline constexpr std::uint8_t kMostDeadlineLevel = 4;

/// Where a picture's pixels lie, in the transducer frame. The point at depth d of pixel (column, row) is
/// origin + d * forward + (mm_per_pixel + d * mm_per_pixel_per_mm) * ((column - middle_column) * right +
/// (row - middle_row) * down). Depths lie along forward, unit vectors all three.
struct PictureView {
  std::array<double, 3> origin_mm{};
  std::array<double, 3> right{};
  std::array<double, 3> down{};
  std::array<double, 3> forward{};
  double mm_per_pixel = 0;         ///< in the view plane
  double mm_per_pixel_per_mm = 0;  ///< 0 in a parallel projection
  double middle_column = 0;
  double middle_row = 0;
};

/// Identity and time of one picture.
struct PictureStamp {
  std::uint64_t view_id = 0;         ///< 0: the main view; else PrivateView::view_id
  std::uint64_t picture_id = 0;      ///< counts the pictures of a view from 1
  std::uint64_t scene_revision = 0;  ///< of the scene that it shows
  std::uint64_t pass1_runs = 0;      ///< of the renderer when this picture was submitted
  std::uint64_t pass2_runs = 0;
  std::uint8_t deadline_level = 0;  ///< see DeadlineState
  DeadlineMeasures measures;        ///< that this picture was made with
  VolumeStamp volume;
  PictureView view;
  std::array<double, kStages> stage_ms{};  ///< 0 where the stage did not run for this picture
  std::int64_t finished_time_ns = 0;       ///< fanlight::now_ns
};

/// One finished picture. `rgba`: height x width x 4 bytes, row major, top row first, sRGB values, alpha 255.
/// `depth_mm`: height x width, likewise, of the surface as it is lit; negative where there is none.
struct Picture {
  PictureStamp stamp;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgba;
  std::vector<float> depth_mm;
};

/// A black one with all the memory that it will need, so that taking a finished one allocates nothing.
inline Picture blank_picture(std::uint32_t width, std::uint32_t height) {
  Picture blank{.width = width, .height = height};
  blank.rgba.resize(std::size_t{4} * width * height);
  blank.depth_mm.resize(std::size_t{width} * height);
  return blank;
}

/// A scene and the number under which the server accepted it.
struct NumberedScene {
  std::uint64_t revision = 0;
  Scene scene;
  DeadlineState deadline{};  ///< where the scene is not the one asked for but what its plan made of that
};

}  // namespace fanlight
