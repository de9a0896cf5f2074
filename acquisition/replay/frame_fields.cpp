// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/frame_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acquisition/sequence/plus_fields.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kMostFramesUndescribed = 100;  // between two that are
constexpr std::size_t kMostFanlightFields = 64;
constexpr std::string_view kOrientations = "MF, MN, UF, UN, FM, FU, NM or NU, with or without A or D behind";
constexpr std::string_view kFramePrefix = "Seq_Frame";

/// The turn from one matrix to another by the trace of their product; the columns may have any length.
void add_motion(FrameSequence::Motion& motion, const std::array<double, 16>& matrix) {
  const std::array<double, 16>& first = motion.first;
  motion.most_mm = std::max(motion.most_mm,
                            std::hypot(matrix[3] - first[3], matrix[7] - first[7], matrix[11] - first[11]));
  double trace = 0;
  for (std::size_t column = 0; column < 3; ++column) {
    double product = 0;
    double first_length = 0;
    double length = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      const double a = first[4 * row + column];
      const double b = matrix[4 * row + column];
      product += a * b;
      first_length += a * a;
      length += b * b;
    }
    const double lengths = std::sqrt(first_length * length);
    trace += lengths > 0 ? product / lengths : 1;
  }
  const double turn_deg = degrees(std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)));
  motion.most_deg = std::max(motion.most_deg, turn_deg);
}

}  // namespace

Result<bool> FrameFields::take(const HeaderField& field) {
  if (field.key.starts_with(kFramePrefix)) {
    const auto taken = take_frame_field(field);
    return taken ? Result<bool>(true) : taken.error();
  }
  if (!field.key.starts_with("Fanlight")) return false;
  auto& fields = header_.sequence.fanlight_fields;
  if (fields.size() == kMostFanlightFields)
    return bad(fmt::format("the header has more than {} Fanlight fields", kMostFanlightFields), "fewer");
  fields.emplace(field.key, field.value);
  return true;
}

Result<void> FrameFields::set_size(const HeaderField& field, std::uint64_t columns, std::uint64_t rows,
                                   std::uint64_t frames) {
  const bool fits = columns >= 2 && columns <= kMostSide && rows >= 2 && rows <= kMostSide && frames >= 1 &&
                    frames <= kMostFrames;
  if (!fits) {
    return field.refused(from_, "three numbers: columns and rows from 2 to 4096, frames from 1 to 1000000");
  }
  if (header_.sequence.frames.size() > frames) {
    return field.refused(from_, fmt::format("the {} frames that the lines before it describe",
                                            header_.sequence.frames.size()));
  }
  has_size_ = true;
  header_.sequence.columns = static_cast<std::uint32_t>(columns);
  header_.sequence.rows = static_cast<std::uint32_t>(rows);
  header_.frames = frames;
  return {};
}

Result<void> FrameFields::set_orientation(const HeaderField& field) {
  const auto orientation = ImageOrientation::from_letters(field.value);
  if (!orientation) return field.refused(from_, kOrientations, ErrorCode::kUnsupported);
  header_.orientation = *orientation;
  has_orientation_ = true;
  return {};
}

Result<void> FrameFields::check() const {
  if (!has_size_) return bad("the header has no size of the frames", "columns, rows and frames");
  if (!last_frame_) {
    return bad("this is neither a volume on a grid, with a spacing, nor does it describe frames of a sweep",
               "lines such as Seq_Frame0000_Timestamp for each frame, as PLUS writes them",
               ErrorCode::kUnsupported);
  }
  if (has_orientation_) return {};
  // Not guessed: a wrong orientation shows a mirror image of the body.
  return bad("the header has no UltrasoundImageOrientation", kOrientations, ErrorCode::kUnsupported);
}

Result<FrameFields::OfFrame> FrameFields::of_frame(const HeaderField& field) {
  auto& frames = header_.sequence.frames;
  const std::string_view numbered = field.key.substr(kFramePrefix.size());
  const auto underscore = numbered.find('_');
  const auto index = number_in<std::uint32_t>(numbered.substr(0, underscore));
  if (underscore == std::string_view::npos || !index)
    return bad(fmt::format("the header has a field {}", in_quotes(field.key)), "Seq_Frame0000_Name");
  // Older files of PLUS give the size after the frames.
  if (*index >= (has_size_ ? header_.frames : kMostFrames)) {
    return bad(fmt::format("the header describes frame {}", *index),
               fmt::format("the {} frames of its size, from 0", header_.frames));
  }
  // The list grows with the lines, so that a short header takes little memory.
  if (*index > frames.size() + kMostFramesUndescribed) {
    return bad(fmt::format("the header describes frame {} after frame {}", *index, frames.size()),
               "the frames in their order");
  }
  if (*index >= frames.size()) frames.resize(*index + 1);
  return OfFrame{frames[*index], *index, numbered.substr(underscore + 1)};
}

Result<void> FrameFields::take_frame_field(const HeaderField& field) {
  const auto described = of_frame(field);
  if (!described) return described.error();
  const auto& [frame, index, name] = *described;
  // The lines of a frame stand together.
  if (std::exchange(last_frame_, index) != index) keys_of_frame_.clear();
  const auto [first, is_new] = keys_of_frame_.emplace(name, field.value);
  if (!is_new && first->second == field.value) return {};
  if (!is_new) return field.refused(from_, fmt::format("the same as before, {}", in_quotes(first->second)));
  if (name == "Timestamp") return take_number(field, frame.timestamp_s, "seconds");
  if (name == "MotorAngleDeg") return take_number(field, frame.motor_angle_deg, "degrees");
  if (name == "VolumeIndex") return take_number(field, frame.volume_index, "a whole number from 0");
  if (name == "FrameIndex") return take_number(field, frame.frame_index, "a whole number from 0");
  if (name == plus_field::kMotorAngleRad) return take_number(field, frame.motor_angle_rad, "radians");
  if (name == plus_field::kFrameSequence) return take_number(field, frame.sequence, "a whole number from 0");
  if (name == plus_field::kFramesInSweep)
    return take_number(field, frame.frames_in_sweep, "a whole number from 0");
  if (name == plus_field::kAfterInterruption) frame.after_interruption = field.value == "1";
  if (name == plus_field::kFrameFault) {
    const auto fault = fault_named(field.value);
    if (!fault) return field.refused(from_, "invalid, damaged, cut or misfit");
    frame.fault = *fault;
  }
  if (name.ends_with("Transform") && (name.starts_with("Image") || name.starts_with("Probe")))
    return take_transform(field, *described);
  if (name == "ImageStatus" || name == "Status") {
    if (field.value != "OK" && field.value != "INVALID") return field.refused(from_, "OK or INVALID");
    frame.valid = field.value == "OK";
  }
  if (name == "SweepDirection") {
    if (field.value != "FORWARD" && field.value != "BACKWARD")
      return field.refused(from_, "FORWARD or BACKWARD");
    frame.direction = field.value == "FORWARD" ? SweepDirection::kForward : SweepDirection::kBackward;
  }
  return {};
}

template <typename T>
Result<void> FrameFields::take_number(const HeaderField& field, std::optional<T>& number,
                                      std::string_view expected) const {
  if (number) return field.refused(from_, "each line of a frame once");
  number = number_in<T>(field.value);
  if (!number) return field.refused(from_, expected);
  return {};
}

/// The pixel size is the lengths of the matrix's first two columns: mm along the image's x and y axes.
Result<void> FrameFields::take_transform(const HeaderField& field, const OfFrame& of) {
  const std::string_view name = of.name;
  std::array<double, 16> matrix{};  // row order
  FrameSequence& sequence = header_.sequence;
  const bool sets_pixel_size = name == "ImageToReferenceTransform" && !sequence.pixel_size;
  if (!take_numbers<double>(field.value, matrix)) {
    if (sets_pixel_size) return field.refused(from_, "a matrix of 16 numbers");
    return {};
  }
  // PLUS writes the identity where the tracker saw nothing.
  constexpr std::array<double, 16> kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (matrix == kIdentity) return {};
  if (name == "ImageToReferenceTransform") of.frame.pose = matrix;
  if (sets_pixel_size) {
    sequence.pixel_size = {.width_mm = std::hypot(matrix[0], matrix[4], matrix[8]),
                           .height_mm = std::hypot(matrix[1], matrix[5], matrix[9])};
  }
  constexpr std::size_t kMostTransforms = 16;
  auto motion = sequence.motions.find(name);
  if (motion == sequence.motions.end()) {
    if (sequence.motions.size() < kMostTransforms)
      sequence.motions.emplace(name, FrameSequence::Motion{matrix});
    return {};
  }
  add_motion(motion->second, matrix);
  return {};
}

}  // namespace fanlight
