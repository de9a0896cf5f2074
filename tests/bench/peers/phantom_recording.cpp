// SPDX-License-Identifier: Apache-2.0
// Writes volumes of the simulated probe to a recording (.igs.mha, not compressed), for programs that cannot
// use the phantom. The header contains the geometry, each frame its motor angle.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "tests/support/igs_file.hpp"

namespace fanlight {
namespace {

[[noreturn]] void fail(const Error& error) {
  fmt::print(stderr, "phantom_recording: {}\n", error.message);
  std::exit(1);
}

test::NamedFile::Fields geometry_fields(const FanGeometry& geometry) {
  return {{"FanlightFrameKind", "cartesian"},
          {"FanlightPixelWidthMm", fmt::format("{}", geometry.pixel_width_mm)},
          {"FanlightPixelHeightMm", fmt::format("{}", geometry.pixel_height_mm)},
          {"FanlightFaceColumn", fmt::format("{}", geometry.face_column)},
          {"FanlightFaceRow", fmt::format("{}", geometry.face_row)},
          {"FanlightMotorRadiusMm", fmt::format("{}", geometry.motor_radius_mm)},
          {"FanlightProbeRadiusMm", fmt::format("{}", geometry.probe_radius_mm)},
          {"FanlightSectorHalfAngleDeg", fmt::format("{}", geometry.sector.half_angle_deg)},
          {"FanlightSectorReachMm", fmt::format("{}", geometry.sector.reach_mm)}};
}

test::NamedFile::Fields frame_fields(const FrameStamp& frame) {
  const bool forward = frame.direction == SweepDirection::kForward;
  return {{"Timestamp", fmt::format("{:.9f}", static_cast<double>(frame.capture_time_ns) * 1e-9)},
          {"FrameIndex", fmt::format("{}", frame.frame_index)},
          {"VolumeIndex", fmt::format("{}", frame.volume_index)},
          {"MotorAngleDeg", fmt::format("{}", degrees(frame.angle_rad))},
          {"SweepDirection", forward ? "FORWARD" : "BACKWARD"},
          {"ImageStatus", "OK"}};
}

/// All volumes of the source. The source must end and deliver Cartesian frames.
test::NamedFile recording_of(PhantomSource& source) {
  const FanGeometry& geometry = source.description().geometry;
  test::NamedFile file{.columns = geometry.columns, .rows = geometry.rows, .compressed = false};
  for (auto& field : geometry_fields(geometry)) file.header.push_back(std::move(field));
  for (;;) {
    const auto frame = source.next_frame({});
    if (!frame) fail(frame.error());
    if (!*frame) return file;
    file.frames.push_back(frame_fields(**frame));
    file.pixels.resize(file.pixels.size() + geometry.frame_bytes());
    source.read_pixels(std::span(file.pixels).last(geometry.frame_bytes()), {});
  }
}

void record(const std::string& path, const std::string& options, std::uint64_t volumes) {
  auto config = parse_phantom(options, {.pace = PhantomSource::Pace::kUnpaced});
  if (!config) fail(config.error());
  config->volumes = volumes;
  if (config->scan != FrameKind::kCartesian) {
    fail({ErrorCode::kInvalidArgument, "the phantom gives scan lines, expected scan=cartesian"});
  }
  const auto source = PhantomSource::create(*config);
  if (!source) fail(source.error());
  test::write_file(path, recording_of(**source).bytes());
}

}  // namespace
}  // namespace fanlight

int main(int count, char** arguments) {
  std::string path;
  std::string options;
  std::uint64_t volumes = 2;
  CLI::App program("Writes volumes of the simulated probe to a recording");
  program.add_option("FILE", path, "The recording to write, such as x.igs.mha")->required();
  program.add_option("--phantom", options, "Its options, as after \"phantom:scene=relief,probe=r1,\"");
  program.add_option("--volumes", volumes, "How many")->check(CLI::Range(1, 100));
  CLI11_PARSE(program, count, arguments);
  fanlight::record(path, options, volumes);
  return 0;
}
