// SPDX-License-Identifier: Apache-2.0
#include "server/stream/picture_message.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr std::uint16_t kNoSurface = 65535;

}  // namespace

void describe(v1::View& message, const PictureView& view) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (const auto* axis : {&view.right, &view.down, &view.forward, &view.origin_mm})
      message.add_matrix((*axis)[row]);
  }
  for (const double value : {0.0, 0.0, 0.0, 1.0}) message.add_matrix(value);
  message.set_mm_per_pixel(view.mm_per_pixel);
  message.set_mm_per_pixel_per_mm(view.mm_per_pixel_per_mm);
  message.set_middle_column(view.middle_column);
  message.set_middle_row(view.middle_row);
}

void describe(v1::Picture& message, const Picture& picture) {
  const PictureStamp& stamp = picture.stamp;
  message.set_picture_id(stamp.picture_id);
  message.set_private_view(stamp.view_id != 0);
  message.set_volume_id(stamp.volume.volume_id);
  message.set_first_frame_sequence(stamp.volume.first_frame_sequence);
  message.set_last_frame_sequence(stamp.volume.last_frame_sequence);
  message.set_capture_time_ns(stamp.volume.last_capture_time_ns);
  message.set_finished_time_ns(stamp.finished_time_ns);
  message.set_scene_revision(stamp.scene_revision);
  message.set_pass1_runs(stamp.pass1_runs);
  message.set_pass2_runs(stamp.pass2_runs);
  message.set_frames_missing(stamp.volume.frames_missing);
  message.set_angle_correction_deg(degrees(stamp.volume.angle_correction_rad));
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    v1::StageTime& time = *message.add_stages();
    time.set_name(std::string(kStageNames[stage]));
    time.set_milliseconds(stamp.stage_ms[stage]);
  }
  message.set_deadline_level(stamp.deadline_level);
  const DeadlineMeasures& measures = stamp.measures;
  if (measures.coarse) message.add_measures("coarse picture");
  if (measures.wide_step) message.add_measures("wide step");
  if (measures.cheap_filters) message.add_measures("cheap filters");
  describe(*message.mutable_view(), stamp.view);
  stamp.volume.warnings.for_each([&message](const SweepWarningText& text) {
    v1::SweepWarning& warning = *message.add_warnings();
    warning.set_name(std::string(text.name));
    warning.set_sentence(std::string(text.sentence));
  });
  message.set_surface_share(stamp.surface_share);
  message.set_uncertain_share(stamp.uncertain_share);
  message.set_steady_share(stamp.steady_share);
  message.set_mean_volumes(stamp.mean_volumes);
  message.set_seam_frames(static_cast<std::uint32_t>(stamp.seam_frames));
  const auto [first, last] =
      std::minmax(stamp.volume.first_recorded_number, stamp.volume.last_recorded_number);
  message.set_first_frame_number(first);
  message.set_last_frame_number(last);
  message.set_near_tissue(static_cast<v1::NearTissue>(stamp.near_tissue));
  if (std::isfinite(stamp.near_end_mm)) message.set_near_end_mm(stamp.near_end_mm);
  const Point& samples = stamp.sample_distances;
  for (const double distance_mm : {samples.x_mm, samples.y_mm, samples.z_mm})
    message.add_sample_mm(distance_mm);
  if (stamp.levels.flat) message.mutable_levels()->set_flat(true);
  if (!stamp.levels.known) return;
  v1::EchoLevels& levels = *message.mutable_levels();
  levels.set_fluid(stamp.levels.fluid);
  levels.set_tissue(stamp.levels.tissue);
  levels.set_noise(stamp.levels.noise);
  levels.set_threshold(stamp.levels.threshold());
  levels.set_linear(stamp.levels.linear());
  levels.set_least_tissue(stamp.levels.least_tissue());
}

std::string packed_depth(std::span<const float> depths_mm) {
  if (depths_mm.empty()) return {};
  std::vector<std::uint8_t> plain;
  plain.reserve(2 * depths_mm.size());
  for (const float depth_mm : depths_mm) {
    const double units = std::round(depth_mm / kDepthUnitMm);
    const auto word = depth_mm < 0 || units >= kNoSurface ? kNoSurface : static_cast<std::uint16_t>(units);
    plain.push_back(static_cast<std::uint8_t>(word & 255));
    plain.push_back(static_cast<std::uint8_t>(word >> 8));
  }
  uLongf bytes = compressBound(plain.size());
  std::string packed(bytes, '\0');
  const int failed =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &bytes, plain.data(), plain.size(), Z_BEST_SPEED);
  packed.resize(failed == Z_OK ? bytes : 0);
  return packed;
}

v1::DepthReply::Point point_at(const Picture& picture, PictureSize counted, std::uint32_t counted_column,
                               std::uint32_t counted_row) {
  v1::DepthReply::Point point;
  if (counted_column >= counted.width || counted_row >= counted.height || picture.depth_mm.empty())
    return point;
  // The pixel that the centre of the counted one lies in.
  const auto pixel_at = [](std::uint32_t index, std::uint32_t of, std::uint32_t pixels) {
    return static_cast<std::uint32_t>((2 * std::uint64_t{index} + 1) * pixels / (2 * std::uint64_t{of}));
  };
  const std::uint32_t column = pixel_at(counted_column, counted.width, picture.width);
  const std::uint32_t row = pixel_at(counted_row, counted.height, picture.height);
  const double depth_mm = picture.depth_mm[std::size_t{row} * picture.width + column];
  if (depth_mm < 0) return point;
  const PictureView& view = picture.stamp.view;
  const double scale = view.mm_per_pixel + depth_mm * view.mm_per_pixel_per_mm;
  const double across = scale * (column - view.middle_column);
  const double down = scale * (row - view.middle_row);
  const auto at = [&](std::size_t axis) {
    return view.origin_mm[axis] + depth_mm * view.forward[axis] + across * view.right[axis] +
           down * view.down[axis];
  };
  point.set_surface(true);
  point.set_depth_mm(depth_mm);
  point.set_x_mm(at(0));
  point.set_y_mm(at(1));
  point.set_z_mm(at(2));
  return point;
}

}  // namespace fanlight
