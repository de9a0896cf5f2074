// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/seen_sector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "acquisition/replay/recording_file.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostFramesSeen = 64;
// What the guess is good to (tests/formats/sector_guess_test.cpp), with some room.
constexpr double kFaceMm = 2;
constexpr double kRadiusMm = 3;
constexpr double kRadiusShare = 0.1;
constexpr double kLeastHalfAngleDeg = 10;
// A sector that leans is a part of one: the rest had no contact.
constexpr double kMostLeanDeg = 2;

}  // namespace

std::optional<FanGeometry> with_sector(const FanGeometry& geometry, const SectorGuess& seen) {
  if (!seen.diverges || seen.half_angle_deg < kLeastHalfAngleDeg || std::abs(seen.lean_deg) > kMostLeanDeg)
    return std::nullopt;
  const double row_mm = geometry.pixel_height_mm;
  const double radius_mm = (geometry.face_row - seen.apex_row) * row_mm;
  const bool fits_face =
      std::abs(seen.face_column - geometry.face_column) * geometry.pixel_width_mm <= kFaceMm &&
      std::abs(seen.face_row - geometry.face_row) * row_mm <= kFaceMm && radius_mm > 0;
  const double known_mm = geometry.probe_radius_mm;
  const bool fits_radius =
      known_mm == 0 || std::abs(radius_mm - known_mm) <= std::max(kRadiusMm, kRadiusShare * known_mm);
  if (!fits_face || !fits_radius) return std::nullopt;
  FanGeometry found = geometry;
  if (known_mm == 0) found.probe_radius_mm = radius_mm;
  // Down to the last row: a body may lie below all that is bright in most beams.
  found.sector = {.half_angle_deg = seen.half_angle_deg, .reach_mm = 0};
  return check(found) ? std::optional(found) : std::nullopt;
}

Result<std::optional<FanGeometry>> see_sector(const std::filesystem::path& path, std::uint64_t max_bytes,
                                              const FanGeometry& geometry) {
  if (geometry.kind != FrameKind::kCartesian || geometry.sector.half_angle_deg > 0)
    return std::optional<FanGeometry>();
  auto opened = open_recording_file(path, max_bytes);
  if (!opened) return opened.error();
  const std::size_t frames = opened->sequence.frames.size();
  // Of compressed pixels the first ones: to reach the others all would be unpacked.
  const bool spreads = opened->pixels.has_quick_access();
  const std::size_t step = spreads ? std::max<std::size_t>(1, frames / kMostFramesSeen) : 1;
  const std::size_t end = spreads ? frames : std::min(frames, kMostFramesSeen);
  std::vector<std::uint8_t> brightest(opened->sequence.frame_bytes());
  std::vector<std::uint8_t> pixels(brightest.size());
  for (std::size_t frame = 0; frame < end; frame += step) {
    // Damage is reported by who reads that frame.
    if (!opened->pixels.read(frame, pixels)) break;
    std::ranges::transform(brightest, pixels, brightest.begin(),
                           [](std::uint8_t most, std::uint8_t pixel) { return std::max(most, pixel); });
  }
  const auto seen = guess_sector(brightest, geometry.columns, geometry.rows,
                                 geometry.pixel_width_mm / geometry.pixel_height_mm);
  return seen ? with_sector(geometry, *seen) : std::optional<FanGeometry>();
}

std::string note_on_seen_sector(const FanGeometry& geometry) {
  return fmt::format(
      "The scanned sector is taken from the pictures: {:.1f} deg to either side, beginning {:.0f} mm from "
      "its "
      "apex. Its border is no surface. Set sector_half_angle_deg in the geometry to correct it, or unscanned "
      "= "
      "\"none\" to ignore it.",
      geometry.sector.half_angle_deg, geometry.probe_radius_mm);
}

}  // namespace fanlight
