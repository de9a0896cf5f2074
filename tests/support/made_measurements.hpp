// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/fanlight.pb.h"

namespace fanlight::test {

/// A distance in a plane, on the volume of these frames.
inline v1::Measurement distance(std::uint64_t id, std::uint64_t first = 10, std::uint64_t last = 19) {
  v1::Measurement measurement;
  measurement.set_id(id);
  measurement.set_name(std::to_string(id));
  measurement.set_place("in plane A");
  for (const double x_mm : {0.0, 12.5}) measurement.add_points()->set_x_mm(x_mm);
  v1::Measurement::Figure& figure = *measurement.add_figures();
  figure.set_name("straight");
  figure.set_value(12.5);
  figure.set_unit("mm");
  figure.set_deviation(0.2);
  measurement.set_first_frame_number(first);
  measurement.set_last_frame_number(last);
  return measurement;
}

/// A region of fluid of `side` cells along each axis.
inline v1::Measurement fluid(std::uint64_t id, std::uint32_t side = 48) {
  v1::Measurement measurement = distance(id);
  measurement.set_kind(v1::Measurement::FLUID);
  measurement.mutable_points()->RemoveLast();
  v1::FluidRegion& region = *measurement.mutable_region();
  region.set_step_mm(0.5);
  region.set_columns(side);
  region.set_rows(side);
  region.set_slices(side);
  region.set_depths(std::string(std::size_t{side} * side * side, '\x80'));
  return measurement;
}

inline v1::MeasurementRequest adding(const v1::Measurement& measurement) {
  v1::MeasurementRequest request;
  *request.mutable_add() = measurement;
  return request;
}

inline v1::ClientMessage sent(const v1::MeasurementRequest& request) {
  v1::ClientMessage message;
  *message.mutable_measurement() = request;
  return message;
}

}  // namespace fanlight::test
