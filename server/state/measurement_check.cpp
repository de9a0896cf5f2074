// SPDX-License-Identifier: Apache-2.0
#include "server/state/measurement_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "proto/base/printable.hpp"
#include "server/state/measurement_store.hpp"

namespace fanlight {

namespace {

constexpr double kMostMm = 10'000;
constexpr double kMostValue = 1e7;
constexpr std::int64_t kMostUnixMs = 8'640'000'000'000'000;  // that ECMAScript's Date takes
constexpr std::size_t kLongestPlace = 1000;
constexpr int kMostFigures = 8;
constexpr std::uint32_t kLeastCells = 2;  // along each axis of a region's grid
constexpr std::uint32_t kMostCells = 48;

Result<void> unless(bool is_wrong, const std::string& expected) {
  return is_wrong ? Result<void>(Error{ErrorCode::kInvalidArgument, expected}) : Result<void>();
}

bool is_place(const v1::Measurement::Point& point) {
  const auto fits = [](double mm) { return std::isfinite(mm) && std::abs(mm) <= kMostMm; };
  return fits(point.x_mm()) && fits(point.y_mm()) && fits(point.z_mm());
}

bool is_text(const std::string& text, std::size_t most_bytes) {
  return text.size() <= most_bytes && is_printable(text);
}

bool is_figure(const v1::Measurement::Figure& figure) {
  return is_text(figure.name(), MeasurementStore::kLongestName) &&
         is_text(figure.unit(), MeasurementStore::kLongestName) && std::abs(figure.value()) <= kMostValue &&
         figure.deviation() >= 0 && figure.deviation() <= kMostValue;
}

bool is_region(const v1::FluidRegion& region) {
  const auto fits = [](std::uint32_t cells) { return cells >= kLeastCells && cells <= kMostCells; };
  if (!fits(region.columns()) || !fits(region.rows()) || !fits(region.slices())) return false;
  const std::size_t cells = std::size_t{region.columns()} * region.rows() * region.slices();
  const auto is_finite = [](double value) { return std::isfinite(value) && std::abs(value) <= 1e9; };
  return region.depths().size() == cells && region.step_mm() > 0 && region.step_mm() <= kMostMm &&
         is_finite(region.first_x_mm()) && is_finite(region.first_y_mm()) && is_finite(region.first_z_mm()) &&
         is_finite(region.volume_mm3()) && is_finite(region.deviation_mm3()) &&
         is_finite(region.fluid_level()) && is_finite(region.border_level()) &&
         is_finite(region.wall_level());
}

Result<void> check_places(const v1::Measurement& measurement) {
  const auto fit = [](const auto& points) {
    return points.size() <= MeasurementStore::kMostPoints && std::ranges::all_of(points, is_place);
  };
  const bool is_right = fit(measurement.points()) && fit(measurement.path()) &&
                        is_place(measurement.across()) && is_place(measurement.deviation_mm());
  return unless(!is_right, fmt::format("points and path: expected at most {} each, within 10 m of the probe",
                                       MeasurementStore::kMostPoints));
}

/// How many points a kind has.
Result<void> check_count(const v1::Measurement& measurement) {
  struct Count {
    int least;
    int most;
  };
  constexpr std::array<Count, 6> kCounts = {
      {{2, 2}, {3, 3}, {3, 3}, {3, MeasurementStore::kMostPoints}, {1, 1}, {0, 0}}};
  static_assert(v1::Measurement::Kind_MAX == 5, "a row for each kind");
  const auto [least, most] = kCounts.at(static_cast<std::size_t>(measurement.kind()));
  const int points = measurement.points_size();
  if (points < least || points > most) {
    const std::string range = least == most ? std::to_string(least) : fmt::format("{} to {}", least, most);
    return unless(true, fmt::format("points: {} has {}, expected {}",
                                    v1::Measurement::Kind_Name(measurement.kind()), points, range));
  }
  const bool may_have_path = measurement.kind() == v1::Measurement::DISTANCE;
  return unless(!may_have_path && measurement.path_size() > 0, "path: expected none but for a DISTANCE");
}

}  // namespace

Result<void> check_measurement_name(const std::string& name) {
  const bool is_blank = name.find_first_not_of(' ') == std::string::npos;
  return unless(
      is_blank || !is_text(name, MeasurementStore::kLongestName),
      fmt::format("name: expected 1 to {} bytes without control characters", MeasurementStore::kLongestName));
}

Result<void> check_measurement(const v1::Measurement& measurement) {
  using Kind = v1::Measurement;
  if (auto named = check_measurement_name(measurement.name()); !named) return named;
  if (auto placed = check_places(measurement); !placed) return placed;
  const auto& figures = measurement.figures();
  const bool are_figures =
      !figures.empty() && figures.size() <= kMostFigures && std::ranges::all_of(figures, is_figure);
  const bool has_region = measurement.has_region() && is_region(measurement.region());
  const bool is_fluid = measurement.kind() == Kind::FLUID;
  for (const auto& [is_wrong, expected] : {
           std::pair(!Kind::Kind_IsValid(measurement.kind()),
                     "kind: expected DISTANCE, ANGLE, ELLIPSE, AREA, FLUID or VOLUME"),
           std::pair(!is_text(measurement.place(), kLongestPlace),
                     "place: expected at most 1000 bytes of text"),
           std::pair(!are_figures,
                     "figures: expected 1 to 8, each with a value and a deviation from 0 on, up to 1e7"),
           std::pair(is_fluid != has_region || measurement.has_region() != has_region,
                     "region: expected one for fluid, as a FluidReply has it, and none for other kinds"),
           std::pair(measurement.captured_unix_ms() < 0 || measurement.captured_unix_ms() > kMostUnixMs,
                     "captured_unix_ms: expected 0 to 8.64e15"),
           std::pair(
               measurement.first_frame_number() >= measurement.last_frame_number(),
               "first_frame_number, last_frame_number: expected those of a picture, the first one smaller"),
       }) {
    if (is_wrong) return Error{ErrorCode::kInvalidArgument, expected};
  }
  return check_count(measurement);
}

}  // namespace fanlight
