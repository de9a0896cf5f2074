// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/phantom_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "acquisition/source/printable.hpp"
#include "proto/base/nearest_name.hpp"

namespace fanlight {

namespace {

using Config = PhantomSource::Config;

struct Bound {
  std::string_view name;
  double value;
  double minimum;
  double maximum;
  std::string_view unit;
};

/// Keeps at least two frames in a sweep, and all angles well below 90 deg.
double most_turning(const Config& config) {
  const double step_deg = config.sweep_deg / (config.frames_per_volume - 1);
  return std::floor(
      std::min({16.0, (config.frames_per_volume - 2) / 2.0, (85 - config.sweep_deg / 2) / step_deg}));
}

}  // namespace

Result<void> check_phantom(const Config& config) {
  const Bound bounds[] = {
      {"rate", config.frame_rate_hz, 0.1, 1000, " frames a second"},
      {"frames", static_cast<double>(config.frames_per_volume), 2, 1024, " a volume"},
      {"columns", static_cast<double>(config.columns), 16, 4096, ""},
      {"rows", static_cast<double>(config.rows), 16, 4096, ""},
      {"sweep", config.sweep_deg, 1, 170, " deg"},
      {"beam", config.beam_mm, 0, 8, " mm"},
      {"range", config.scale.range_db, 20, 120, " dB"},
      {"gain", config.scale.gain_db, -40, 40, " dB"},
      {"lag", config.lag_deg, -4, 4, " deg"},
      {"jitter", config.jitter_deg, 0, 2, " deg"},
      {"turning", static_cast<double>(config.turning_frames), 0, most_turning(config), " frames here"},
      {"lost", config.lost_percent, 0, 50, " percent"},
  };
  for (const Bound& bound : bounds) {
    if (!(bound.value >= bound.minimum && bound.value <= bound.maximum)) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the phantom's {} is {}, expected {} to {}{}", bound.name, bound.value,
                               bound.minimum, bound.maximum, bound.unit)};
    }
  }
  return {};
}

namespace {

template <typename T>
bool read_number(std::string_view text, T& number) {
  const auto read = number_in<T>(text);
  number = read.value_or(number);
  return read.has_value();
}

template <typename T>
bool read_switch(std::string_view text, T& choice, T on, T off) {
  choice = text == "on" ? on : off;
  return text == "on" || text == "off";
}

bool read_scan(std::string_view text, FrameKind& scan) {
  constexpr std::string_view kNames[] = {"cartesian", "convex", "linear"};
  const auto* const found = std::ranges::find(kNames, text);
  if (found == std::end(kNames)) return false;
  scan = static_cast<FrameKind>(found - kNames);
  return true;
}

/// The geometry and sampling of a probe; options after it change them.
bool read_probe(std::string_view text, Config& config) {
  const Config base;
  config.frames_per_volume = base.frames_per_volume;
  config.columns = base.columns;
  config.rows = base.rows;
  config.sweep_deg = base.sweep_deg;
  config.probe_radius_mm = base.probe_radius_mm;
  config.motor_radius_mm = base.motor_radius_mm;
  config.scan = base.scan;
  config.beam_mm = base.beam_mm;
  if (text == "r2") {
    config.frames_per_volume = 60;
    config.columns = 192;
    config.probe_radius_mm = 40;
    config.motor_radius_mm = 23;
    config.scan = FrameKind::kConvexLines;
    config.beam_mm = 2.5;
  }
  return text == "r1" || text == "r2";
}

bool read_scene(std::string_view text, PhantomSource::Scene& scene) {
  constexpr std::string_view kNames[] = {"relief", "face", "womb", "sphere", "plane", "cyst"};
  const auto* const found = std::ranges::find(kNames, text);
  if (found == std::end(kNames)) return false;
  scene = static_cast<PhantomSource::Scene>(found - kNames);
  return true;
}

struct Option {
  std::string_view name;
  std::string_view text;
  std::string_view expected;
  bool (*read)(std::string_view text, Config& config);
};

constexpr std::string_view kWholeNumber = "a whole number";
constexpr Option kOptions[] = {
    {"rate", "Frames a second", "0.1 to 1000 frames a second",
     [](std::string_view text, Config& config) { return read_number(text, config.frame_rate_hz); }},
    {"frames", "Frames of a sweep", "2 to 1024 a volume",
     [](std::string_view text, Config& config) { return read_number(text, config.frames_per_volume); }},
    {"columns", "Pixels of a frame across, or its scan lines", "16 to 4096",
     [](std::string_view text, Config& config) { return read_number(text, config.columns); }},
    {"rows", "Pixels of a frame along its depth, or samples of a line", "16 to 4096",
     [](std::string_view text, Config& config) { return read_number(text, config.rows); }},
    {"sweep", "Angle from the first frame to the last", "1 to 170 deg",
     [](std::string_view text, Config& config) { return read_number(text, config.sweep_deg); }},
    {"seed", "Seed of the random numbers", kWholeNumber,
     [](std::string_view text, Config& config) { return read_number(text, config.seed); }},
    {"volumes", "Sweeps until the source ends", "a whole number, 0 for no end",
     [](std::string_view text, Config& config) { return read_number(text, config.volumes); }},
    {"beam", "Thickness of the beam across the frame at -6 dB", "0 to 8 mm",
     [](std::string_view text, Config& config) { return read_number(text, config.beam_mm); }},
    {"speckle", "Speckle", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.speckle, PhantomSource::Speckle::kOn, PhantomSource::Speckle::kOff);
     }},
    {"clutter", "Side lobes, and reverberation below the probe", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.clutter, PhantomSource::Clutter::kOn, PhantomSource::Clutter::kOff);
     }},
    {"moving", "Whether the body moves", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.motion, PhantomScene::Motion::kMoving, PhantomScene::Motion::kStill);
     }},
    {"probe", "Frames, scan lines and radii of a probe", "r2 or r1",
     [](std::string_view text, Config& config) { return read_probe(text, config); }},
    {"scene", "The body", "face, womb, relief, sphere, plane or cyst",
     [](std::string_view text, Config& config) { return read_scene(text, config.scene); }},
    {"wall", "Whether the womb has its near wall", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.near_wall, PhantomSource::NearWall::kOn,
                          PhantomSource::NearWall::kOff);
     }},
    {"scan", "What a frame is: pixels, or scan lines of a convex or a linear array",
     "cartesian, convex or linear",
     [](std::string_view text, Config& config) { return read_scan(text, config.scan); }},
    {"compression", "From echo to grey level", "log or linear",
     [](std::string_view text, Config& config) {
       config.scale.kind = text == "linear" ? EchoScale::Kind::kLinear : EchoScale::Kind::kLog;
       return text == "linear" || text == "log";
     }},
    {"range", "Dynamic range of the echo", "20 to 120 dB",
     [](std::string_view text, Config& config) { return read_number(text, config.scale.range_db); }},
    {"gain", "Gain of the echo", "-40 to 40 dB",
     [](std::string_view text, Config& config) { return read_number(text, config.scale.gain_db); }},
    {"lag", "Lag of the motor behind the angles it reports", "-4 to 4 deg",
     [](std::string_view text, Config& config) { return read_number(text, config.lag_deg); }},
    {"jitter", "Noise of the angles", "0 to 2 deg",
     [](std::string_view text, Config& config) { return read_number(text, config.jitter_deg); }},
    {"turning", "Frames while the motor turns", "0 to 16 frames",
     [](std::string_view text, Config& config) { return read_number(text, config.turning_frames); }},
    {"index", "Whether frames have the index of their sweep", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.index, PhantomSource::Index::kOn, PhantomSource::Index::kOff);
     }},
    {"lost", "Share of lost frames", "0 to 50 percent",
     [](std::string_view text, Config& config) { return read_number(text, config.lost_percent); }},
};

}  // namespace

std::vector<PhantomOption> phantom_option_texts() {
  std::vector<PhantomOption> texts;
  for (const Option& option : kOptions) texts.push_back({option.name, option.text, option.expected});
  return texts;
}

Config usual_phantom() {
  Config config{.scene = PhantomSource::Scene::kFace};
  read_probe("r2", config);
  return config;
}

Result<Config> parse_phantom(std::string_view options, Config base) {
  while (!options.empty()) {
    const std::string_view item = options.substr(0, options.find(','));
    options.remove_prefix(std::min(item.size() + 1, options.size()));
    const std::string_view name = item.substr(0, item.find('='));
    const std::string_view value = item.substr(std::min(name.size() + 1, item.size()));

    const auto* const option = std::ranges::find(kOptions, name, &Option::name);
    if (option == std::end(kOptions)) {
      std::vector<std::string> names;
      for (const Option& each : kOptions) names.emplace_back(each.name);
      const std::string meant = nearest_name(name, names);
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the phantom has no option {}, {}", in_quotes(name),
                               meant.empty() ? fmt::format("expected {}", fmt::join(names, ", "))
                                             : fmt::format("did you mean {}?", meant))};
    }
    if (!option->read(value, base)) {
      return Error{ErrorCode::kInvalidArgument, fmt::format("the phantom's {} is {}, expected {}", name,
                                                            in_quotes(value), option->expected)};
    }
  }
  if (const auto checked = check_phantom(base); !checked) return checked.error();
  return base;
}

}  // namespace fanlight
