// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/file_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "acquisition/sequence/recording_geometry.hpp"
#include "acquisition/sequence/tracked_poses.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostFrames = 64;
// Of the few probes whose figures are public: 27 of 40 mm, 28 of 51 mm.
constexpr double kUsualMotorShare = 0.6;  // of the probe's radius
constexpr double kUsualMotorRadiusMm = 30;
constexpr double kUsualDepthMm = 150;
constexpr double kUsualHalfSweepDeg = 20;

template <typename T>
std::uint32_t count_of(const FrameSequence& sequence, std::optional<T> SequenceFrame::*field) {
  return static_cast<std::uint32_t>(std::ranges::count_if(
      sequence.frames, [field](const SequenceFrame& frame) { return (frame.*field).has_value(); }));
}

void count_fields(const FrameSequence& sequence, FileFacts& facts) {
  facts.columns = sequence.columns;
  facts.rows = sequence.rows;
  facts.frames = static_cast<std::uint32_t>(sequence.frames.size());
  facts.format = sequence.format;
  facts.compressed = sequence.compressed;
  facts.pixel_size = sequence.pixel_size;
  facts.pixel_size_origin = sequence.pixel_size_origin;
  facts.with_time = count_of(sequence, &SequenceFrame::timestamp_s);
  facts.with_angle = count_of(sequence, &SequenceFrame::motor_angle_deg);
  facts.with_volume = count_of(sequence, &SequenceFrame::volume_index);
  facts.with_pose = count_of(sequence, &SequenceFrame::pose);
  std::set<std::uint64_t> sweeps;
  for (const SequenceFrame& frame : sequence.frames) {
    if (frame.volume_index) sweeps.insert(*frame.volume_index);
  }
  facts.sweeps = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(sweeps.size()));
}

/// Width of a pixel divided by its height; square where it is not known.
double column_rows(const FileFacts& facts) {
  return facts.pixel_size ? facts.pixel_size->width_mm / facts.pixel_size->height_mm : 1;
}

Result<void> look_at_frames(OpenedSequence& opened, FileFacts& facts) {
  const std::size_t bytes = opened.sequence.frame_bytes();
  const std::size_t step = (facts.frames + kMostFrames - 1) / kMostFrames;
  std::vector<std::uint8_t> brightest(bytes);
  std::vector<std::vector<std::uint8_t>> seen;
  for (std::size_t frame = 0; frame < facts.frames; frame += step) {
    std::vector<std::uint8_t> pixels(bytes);
    if (auto read = opened.pixels.read(frame, pixels); !read) return read;
    for (std::size_t i = 0; i < bytes; ++i) brightest[i] = std::max(brightest[i], pixels[i]);
    if (frame == 0) facts.first_frame = pixels;
    if (facts.middle_frame.empty() && frame >= facts.frames / 2) facts.middle_frame = pixels;
    seen.push_back(std::move(pixels));
  }
  if (facts.middle_frame.empty()) facts.middle_frame = facts.first_frame;
  if (facts.scan_lines) return {};
  facts.sector = guess_sector(brightest, facts.columns, facts.rows, column_rows(facts));
  if (!facts.sector || facts.with_angle > 0) return {};
  StepGuesser guesser(facts.columns, facts.rows, *facts.sector);
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) guesser.add(seen[i], seen[i + 1]);
  facts.step = guesser.guess();
  if (facts.step) facts.step->step_columns /= static_cast<double>(step);
  return {};
}

/// Lines of a geometry file. A guess is rounded to its accuracy: more digits would suggest more.
class Draft {
 public:
  void line(std::string_view key, const std::string& value, std::string_view origin) {
    text_ += origin.empty() ? fmt::format("{} = {}\n", key, value)
                            : fmt::format("{:<30} # {}\n", fmt::format("{} = {}", key, value), origin);
  }
  void number(std::string_view key, double value, std::string_view origin) {
    line(key, fmt::format("{:.6g}", value), origin);
  }
  /// `step`: what the value is good to, for example 0.5 mm.
  void guess(std::string_view key, double value, double step, std::string_view origin) {
    number(key, std::round(value / step) * step + 0.0, origin);  // plus zero: no -0
  }
  void comment(std::string_view sentence) { text_ += fmt::format("# {}\n", sentence); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

constexpr std::string_view kUnknownMotor =
    "UNKNOWN, a usual value: no frame shows it; ask the manufacturer of the probe";
// What guesses are good to. Edges in the frames are found within a pixel or two.
constexpr double kToPixels = 0.5;
constexpr double kToDegrees = 0.5;
constexpr double kToMm = 1;

/// The step that keeps this number of significant digits.
double step_of_digits(double value, int digits) {
  return value == 0 ? 1 : std::pow(10.0, std::floor(std::log10(std::abs(value))) + 1 - digits);
}

double draft_of_lines(const FileFacts& facts, Draft& draft) {
  constexpr std::string_view kAsk = "UNKNOWN, a usual value: no frame shows it; see the scanner's settings";
  constexpr double kProbeRadiusMm = 40;
  draft.line("frame_kind", "\"convex-lines\"",
             "or \"linear-lines\", with pixel_width_mm in place of the two below");
  const double pitch_deg = 70.0 / facts.columns;
  const double height_mm = kUsualDepthMm / facts.rows;
  draft.guess("line_pitch_deg", pitch_deg, step_of_digits(pitch_deg, 2), kAsk);
  draft.guess("probe_radius_mm", kProbeRadiusMm, kToMm, kAsk);
  draft.guess("pixel_height_mm", height_mm, step_of_digits(height_mm, 2), kAsk);
  draft.number("face_column", (facts.columns - 1) / 2.0, "the middle line");
  draft.number("face_row", 0, "lines that begin at the probe's face");
  draft.guess("motor_radius_mm", kUsualMotorShare * kProbeRadiusMm, kToMm, kUnknownMotor);
  return kUsualMotorShare * kProbeRadiusMm;
}

/// As the file says, else a usual value, rounded as it is written: lengths follow from it.
double pixel_height_mm(const FileFacts& facts) {
  if (facts.pixel_size) return facts.pixel_size->height_mm;
  const double height_mm = kUsualDepthMm / facts.rows;
  const double step = step_of_digits(height_mm, 2);
  return std::round(height_mm / step) * step;
}

/// The motor radius.
double draft_of_images(const FileFacts& facts, Draft& draft) {
  constexpr std::string_view kSeen = "GUESS, by the edges of what is bright in the frames";
  const double height_mm = pixel_height_mm(facts);
  const double width_mm = facts.pixel_size ? facts.pixel_size->width_mm : height_mm;
  const std::string_view size_origin =
      facts.pixel_size
          ? facts.pixel_size_origin
          : "UNKNOWN, as if the frame were 150 mm deep: measure the depth scale at the edge of the picture";
  draft.line("frame_kind", "\"cartesian\"", "an image, scan converted by the scanner");
  draft.number("pixel_width_mm", width_mm, size_origin);
  draft.number("pixel_height_mm", height_mm, size_origin);
  const auto& sector = facts.sector;
  const std::string_view face_origin = sector ? kSeen : "UNKNOWN: no edge was found in the frames";
  const double face_row = sector ? sector->face_row : 0;
  draft.guess("face_column", sector ? sector->face_column : (facts.columns - 1) / 2.0, kToPixels,
              face_origin);
  draft.guess("face_row", face_row, kToPixels, face_origin);
  double motor_radius_mm = kUsualMotorRadiusMm;
  constexpr double kFlatMm = 1000;  // an array of a larger radius is flat
  constexpr double kPointMm = 10;   // one of a smaller radius says nothing about the motor
  const double probe_radius_mm = sector ? (sector->face_row - sector->apex_row) * height_mm : 0;
  if (sector && sector->diverges && probe_radius_mm < kFlatMm) {
    const auto follows = [&](double rows) {
      return fmt::format("GUESS, by the edges: {:.0f} rows; change it with pixel_height_mm", rows);
    };
    draft.guess("probe_radius_mm", probe_radius_mm, kToMm, follows(sector->face_row - sector->apex_row));
    draft.guess("sector_half_angle_deg", sector->half_angle_deg, kToDegrees, kSeen);
    draft.guess("sector_reach_mm", (sector->last_row - sector->apex_row) * height_mm, kToMm,
                follows(sector->last_row - sector->apex_row));
    if (probe_radius_mm > kPointMm) motor_radius_mm = kUsualMotorShare * probe_radius_mm;
  }
  if (facts.fit) motor_radius_mm = axis_behind_face_mm(facts);
  draft.guess("motor_radius_mm", motor_radius_mm, kToMm,
              facts.fit ? fmt::format("the poses of the frames, which miss the axis by {:.1f} mm",
                                      facts.fit->residual_mm)
                        : kUnknownMotor);
  return motor_radius_mm;
}

void draft_angles(const FileFacts& facts, double motor_radius_mm, Draft& draft) {
  if (facts.with_angle > 0 || facts.fit) return;
  double half_deg = kUsualHalfSweepDeg;
  std::string origin = "UNKNOWN, a usual value: the frames have no angles";
  if (facts.step && facts.sector) {
    const double height_mm = pixel_height_mm(facts);
    const double width_mm = facts.pixel_size ? facts.pixel_size->width_mm : height_mm;
    const double from_axis_mm = (facts.step->row - facts.sector->face_row) * height_mm + motor_radius_mm;
    const double step_deg = degrees(facts.step->step_columns * width_mm / from_axis_mm);
    const double steps = static_cast<double>(facts.frames) / facts.sweeps - 1;
    half_deg = std::clamp(step_deg * steps / 2, 0.1, 89.0);
    origin = fmt::format(
        "GUESS, by the speckle of neighbouring frames: {} deg from frame to frame, good to a "
        "factor of two",
        std::round(step_deg / step_of_digits(step_deg, 1)) * step_of_digits(step_deg, 1));
  }
  const double step_deg = step_of_digits(half_deg, half_deg < 10 ? 1 : 2);
  draft.guess("first_angle_deg", -half_deg, step_deg, origin);
  draft.guess("last_angle_deg", half_deg, step_deg, origin);
}

}  // namespace

double axis_behind_face_mm(const FileFacts& facts) {
  const double height_mm = pixel_height_mm(facts);
  return (facts.sector ? facts.sector->face_row : 0) * height_mm - facts.fit->axis_mm;
}

Result<FileFacts> look_into(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto opened = open_recording_file(path, max_bytes);
  if (!opened) return opened.error();
  FileFacts facts;
  facts.scan_lines = opened->orientation.lines_in_rows;
  count_fields(opened->sequence, facts);
  // The poses also give the axis where the frames have angles.
  for (SequenceFrame& frame : opened->sequence.frames) frame.motor_angle_deg.reset();
  if (auto fit = fit_poses(path, opened->sequence, opened->orientation)) {
    facts.fit = *std::move(fit);
  } else if (facts.with_angle == 0) {
    facts.no_fan = fit.error().message;
  }
  if (facts.with_angle == 0 && facts.no_fan.empty()) {
    if (auto fan = refuse_tracked_by_hand(path, opened->sequence); !fan) facts.no_fan = fan.error().message;
  }
  if (!facts.format.is_grey()) {
    const auto window = choose_window(path, max_bytes);
    if (!window) return window.error();
    opened->pixels.set_window(*window);
  }
  if (auto looked = look_at_frames(*opened, facts); !looked) return looked.error();
  return facts;
}

std::string geometry_draft(const FileFacts& facts, const std::string& name) {
  Draft draft;
  draft.comment(fmt::format("Geometry of {}, for Fanlight. Check each GUESS and UNKNOWN, and look at", name));
  draft.comment("them with `fanlight info FILE --plot plot.png`, which draws the frames in space.");
  const double motor_radius_mm =
      facts.scan_lines ? draft_of_lines(facts, draft) : draft_of_images(facts, draft);
  draft_angles(facts, motor_radius_mm, draft);
  if (facts.with_time == 0)
    draft.number("frames_per_second", 20, "UNKNOWN, a usual value: the frames have no times");
  if (facts.with_volume == 0 && facts.with_angle == 0) {
    draft.comment("Where there are several sweeps (the angles above are then of one):");
    draft.comment("frames_per_sweep = 40");
    draft.comment("sweep_order = \"to-and-fro\"");
  }
  draft.number("columns", facts.columns, "other recordings are refused");
  draft.number("rows", facts.rows, "");
  return draft.text();
}

Result<std::filesystem::path> write_geometry_draft(const std::filesystem::path& recording,
                                                   const std::string& draft) {
  const std::filesystem::path path = sidecar(recording);
  std::FILE* const file = std::fopen(path.c_str(), "wxe");
  if (file == nullptr) {
    std::error_code failure;
    const bool there = std::filesystem::exists(path, failure);
    return Error{there ? ErrorCode::kInvalidArgument : ErrorCode::kUnavailable,
                 fmt::format("{}: {}, expected {}", shown(path),
                             there ? "there is a geometry already" : "the file cannot be written",
                             there ? "none, or that you edit it" : "a folder where this user may write")};
  }
  const bool written = std::fwrite(draft.data(), 1, draft.size(), file) == draft.size();
  if (std::fclose(file) == 0 && written) return path;
  std::error_code failure;
  std::filesystem::remove(path, failure);
  return Error{ErrorCode::kUnavailable,
               fmt::format("{}: not all of it was written, expected room", shown(path))};
}

}  // namespace fanlight
