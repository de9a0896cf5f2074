#include "acquisition/phantom_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "acquisition/text.hpp"
#include "proto/clock.hpp"

namespace fanlight {

namespace {

using Config = PhantomSource::Config;

constexpr double kFieldMm = 160;
constexpr double kMotorRadiusMm = 30;

// The convex array.
constexpr double kProbeRadiusMm = 50;
constexpr double kSectorHalfAngleDeg = 35;

// The echo, in grey levels by depth below the surface.
constexpr double kFluidGrey = 6;
constexpr double kTissueGrey = 110;
constexpr double kSkinGrey = 70;       // on top of the tissue's
constexpr double kSkinMm = 0.9;        // standard deviation: a bright band of 1 to 2 mm
constexpr double kDecayMm = 70;        // the tissue's brightness falls to 1/e
constexpr double kInterfaceMm = 0.25;  // half width of the step at the surface, below a pixel
constexpr double kEchoBeforeMm = 14;   // where the table begins, before the surface
constexpr double kEchoStepMm = 1.0 / 16;

// Over the thickness of the beam a slanted surface lies at different depths. Its echo is that of a flat one,
// blurred by a Gaussian along depth; the table holds it for each of these standard deviations.
constexpr std::uint32_t kBlurs = 14;
constexpr double kBlurStepMm = 0.4;
constexpr double kSlopeReachMm = 0.75;  // the slope is taken over this much to either side
const double kFullWidths = 2 * std::sqrt(2 * std::log(2.0));  // at half maximum, of a standard deviation of 1
// Frames that the probe keeps while nobody takes them.
constexpr double kBufferedFrames = 8;
constexpr double kNsPerS = 1e9;

constexpr auto kEchoEntries = static_cast<std::uint32_t>((kEchoBeforeMm + kFieldMm) / kEchoStepMm);

std::vector<double> flat_echo() {
  std::vector<double> grey(kEchoEntries);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const double depth_mm = (static_cast<double>(i) + 0.5) * kEchoStepMm - kEchoBeforeMm;
    const double in_skin = depth_mm / kSkinMm;
    const double tissue = kTissueGrey * std::exp(-std::max(depth_mm, 0.0) / kDecayMm) +
                          kSkinGrey * std::exp(-0.5 * in_skin * in_skin);
    const double share = std::clamp(0.5 + 0.5 * depth_mm / kInterfaceMm, 0.0, 1.0);
    grey[i] = kFluidGrey + share * (tissue - kFluidGrey);
  }
  return grey;
}

std::vector<std::uint8_t> echo_table() {
  const std::vector<double> flat = flat_echo();
  const auto last = static_cast<std::int64_t>(flat.size()) - 1;
  std::vector<std::uint8_t> grey;
  grey.reserve(kBlurs * flat.size());
  for (std::uint32_t blur = 0; blur < kBlurs; ++blur) {
    const double deviation = std::max(blur * kBlurStepMm / kEchoStepMm, 1e-3);  // in entries
    const auto reach = static_cast<std::int64_t>(std::ceil(3 * deviation));
    std::vector<double> weights;
    for (std::int64_t away = -reach; away <= reach; ++away) {
      const double share = static_cast<double>(away) / deviation;
      weights.push_back(std::exp(-0.5 * share * share));
    }
    const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (std::int64_t i = 0; i <= last; ++i) {
      double sum = 0;
      for (std::int64_t away = -reach; away <= reach; ++away) {
        sum += weights[away + reach] * flat[std::clamp<std::int64_t>(i + away, 0, last)];
      }
      grey.push_back(static_cast<std::uint8_t>(std::lround(sum / all)));
    }
  }
  return grey;
}

FanGeometry geometry_of(const Config& config) {
  return {.columns = config.columns,
          .rows = config.rows,
          .pixel_width_mm = kFieldMm / config.columns,
          .pixel_height_mm = kFieldMm / config.rows,
          .face_column = (config.columns - 1) / 2.0,
          .face_row = 0,
          .motor_radius_mm = kMotorRadiusMm,
          .sector = {.probe_radius_mm = kProbeRadiusMm,
                     .half_angle_deg = kSectorHalfAngleDeg,
                     .reach_mm = kProbeRadiusMm + kFieldMm}};
}

struct Bound {
  std::string_view name;
  double value;
  double minimum;
  double maximum;
  std::string_view unit;
};

Result<void> check(const Config& config) {
  const Bound bounds[] = {
      {"rate", config.frame_rate_hz, 0.1, 1000, " frames a second"},
      {"frames", static_cast<double>(config.frames_per_volume), 2, 1024, " a volume"},
      {"columns", static_cast<double>(config.columns), 16, 4096, ""},
      {"rows", static_cast<double>(config.rows), 16, 4096, ""},
      {"sweep", config.sweep_deg, 1, 170, " deg"},
      {"beam", config.beam_mm, 0, 8, " mm"},
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

struct Option {
  std::string_view name;
  std::string_view expected;
  bool (*read)(std::string_view text, Config& config);
};

constexpr std::string_view kWholeNumber = "a whole number";
constexpr Option kOptions[] = {
    {"rate", "0.1 to 1000 frames a second",
     [](std::string_view text, Config& config) { return read_number(text, config.frame_rate_hz); }},
    {"frames", "2 to 1024 a volume",
     [](std::string_view text, Config& config) { return read_number(text, config.frames_per_volume); }},
    {"columns", "16 to 4096",
     [](std::string_view text, Config& config) { return read_number(text, config.columns); }},
    {"rows", "16 to 4096",
     [](std::string_view text, Config& config) { return read_number(text, config.rows); }},
    {"sweep", "1 to 170 deg",
     [](std::string_view text, Config& config) { return read_number(text, config.sweep_deg); }},
    {"seed", kWholeNumber,
     [](std::string_view text, Config& config) { return read_number(text, config.seed); }},
    {"volumes", "a whole number, 0 for no end",
     [](std::string_view text, Config& config) { return read_number(text, config.volumes); }},
    {"beam", "0 to 8 mm",
     [](std::string_view text, Config& config) { return read_number(text, config.beam_mm); }},
    {"speckle", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.speckle, PhantomSource::Speckle::kOn, PhantomSource::Speckle::kOff);
     }},
    {"moving", "on or off",
     [](std::string_view text, Config& config) {
       return read_switch(text, config.motion, PhantomScene::Motion::kMoving, PhantomScene::Motion::kStill);
     }},
};

}  // namespace

Result<Config> PhantomSource::parse(std::string_view options, Config base) {
  while (!options.empty()) {
    const std::string_view item = options.substr(0, options.find(','));
    options.remove_prefix(std::min(item.size() + 1, options.size()));
    const std::string_view name = item.substr(0, item.find('='));
    const std::string_view value = item.substr(std::min(name.size() + 1, item.size()));

    const auto* const option = std::ranges::find(kOptions, name, &Option::name);
    if (option == std::end(kOptions)) {
      std::string names;
      for (const Option& each : kOptions) names += fmt::format("{}{}", names.empty() ? "" : ", ", each.name);
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the phantom has no option {}, expected {}", in_quotes(name), names)};
    }
    if (!option->read(value, base)) {
      return Error{ErrorCode::kInvalidArgument, fmt::format("the phantom's {} is {}, expected {}", name,
                                                            in_quotes(value), option->expected)};
    }
  }
  if (const auto checked = check(base); !checked) return checked.error();
  return base;
}

Result<std::unique_ptr<PhantomSource>> PhantomSource::create(const Config& config) {
  if (const auto checked = check(config); !checked) return checked.error();
  return std::unique_ptr<PhantomSource>(new PhantomSource(config));
}

PhantomSource::PhantomSource(const Config& config)
    : config_(config),
      description_{.name = "phantom:",
                   .geometry = geometry_of(config),
                   .frames_per_volume = config.frames_per_volume,
                   .first_angle_rad = radians(-config.sweep_deg / 2),
                   .last_angle_rad = radians(config.sweep_deg / 2)},
      scene_(config.motion),
      speckle_(config.speckle == Speckle::kOn ? SpeckleTile(config.seed) : SpeckleTile()),
      echo_(echo_table()),
      surface_depths_mm_(config.columns),
      depths_below_mm_(config.columns),
      depths_above_mm_(config.columns) {
  const FanGeometry& geometry = description_.geometry;
  const FanGeometry::Sector& sector = geometry.sector;
  for (std::uint32_t row = 0; row < geometry.rows; ++row) {
    const double from_apex_mm = row * geometry.pixel_height_mm + sector.probe_radius_mm;
    const double half_width_mm =
        std::min({from_apex_mm * std::tan(radians(sector.half_angle_deg)), -geometry.left_mm(),
                  std::sqrt(sector.reach_mm * sector.reach_mm - from_apex_mm * from_apex_mm)});
    const double half_columns = half_width_mm / geometry.pixel_width_mm;
    const auto first = static_cast<std::uint32_t>(std::ceil(geometry.face_column - half_columns));
    sector_.push_back({first, geometry.columns - first});
  }
}

double PhantomSource::scene_time_s(const FrameStamp& frame) const {
  return static_cast<double>(frame.capture_time_ns - start_ns_) / kNsPerS;
}

std::int64_t PhantomSource::capture_time_ns(std::uint64_t sequence) const {
  return start_ns_ + std::llround(static_cast<double>(sequence) * (kNsPerS / config_.frame_rate_hz));
}

FrameStamp PhantomSource::stamp(std::uint64_t sequence) const {
  const std::uint32_t frames = config_.frames_per_volume;
  const std::uint64_t sweep = sequence / frames;
  const auto index = static_cast<std::uint32_t>(sequence % frames);
  const auto direction = sweep % 2 == 0 ? SweepDirection::kForward : SweepDirection::kBackward;
  const std::uint32_t place = direction == SweepDirection::kForward ? index : frames - 1 - index;
  return {.sequence = sequence,
          .volume_index = sweep,
          .frame_index = index,
          .frames_in_sweep = frames,
          .direction = direction,
          .angle_rad = std::lerp(description_.first_angle_rad, description_.last_angle_rad,
                                 static_cast<double>(place) / (frames - 1)),
          .capture_time_ns = capture_time_ns(sequence)};
}

Result<std::optional<FrameStamp>> PhantomSource::next_frame(std::stop_token stop) {
  if (config_.pace == Pace::kRealTime) {
    if (next_sequence_ == 0) start_ns_ = now_ns();
    const double late_ns = static_cast<double>(now_ns() - capture_time_ns(next_sequence_));
    const double late_frames = std::floor(late_ns * config_.frame_rate_hz / kNsPerS);
    if (late_frames > kBufferedFrames)
      next_sequence_ += static_cast<std::uint64_t>(late_frames - kBufferedFrames);
    if (!pacer_.wait_until(capture_time_ns(next_sequence_), stop)) return std::optional<FrameStamp>{};
  }
  const bool ended = config_.volumes > 0 && next_sequence_ / config_.frames_per_volume >= config_.volumes;
  if (ended || stop.stop_requested()) return std::optional<FrameStamp>{};
  current_ = stamp(next_sequence_++);
  return std::optional(current_);
}

void PhantomSource::read_pixels(std::span<std::uint8_t> pixels) {
  const FanGeometry& geometry = description_.geometry;
  const PhantomScene::Pose pose = scene_.pose_at(scene_time_s(current_));
  const std::uint64_t speckle_roll = mixed_bits(config_.seed + mixed_bits(current_.sequence + 1));
  for (std::uint32_t row = 0; row < geometry.rows; ++row) {
    draw_row(row, pose, speckle_roll, pixels.subspan(std::size_t{row} * geometry.columns, geometry.columns));
  }
}

void PhantomSource::draw_row(std::uint32_t row, const PhantomScene::Pose& pose, std::uint64_t speckle_roll,
                             std::span<std::uint8_t> pixels) {
  const FanGeometry& geometry = description_.geometry;
  const auto [first, end] = sector_[row];
  std::fill_n(pixels.begin(), first, std::uint8_t{0});
  std::fill(pixels.begin() + end, pixels.end(), std::uint8_t{0});

  const Point at =
      geometry.point(geometry.left_mm() + first * geometry.pixel_width_mm,
                     {.angle_rad = current_.angle_rad, .depth_mm = row * geometry.pixel_height_mm});
  const auto surface_mm = std::span(surface_depths_mm_).first(end - first);
  const auto below_mm = std::span(depths_below_mm_).first(end - first);
  const auto above_mm = std::span(depths_above_mm_).first(end - first);
  if (at.y_mm < scene_.nearest_depth_mm() - kEchoBeforeMm) {
    for (const auto depths_mm : {surface_mm, below_mm, above_mm}) {
      std::ranges::fill(depths_mm, PhantomScene::kNoSurfaceMm);
    }
  } else {
    scene_.surface_row_mm(pose, at.z_mm, at.x_mm, geometry.pixel_width_mm, surface_mm);
    scene_.surface_row_mm(pose, at.z_mm - kSlopeReachMm, at.x_mm, geometry.pixel_width_mm, below_mm);
    scene_.surface_row_mm(pose, at.z_mm + kSlopeReachMm, at.x_mm, geometry.pixel_width_mm, above_mm);
  }

  // A step of e out of the frame's plane goes (-sin, cos) in y and z, and so e (sin + cos dS/dz) deeper or
  // less deep below the surface.
  const double blurs_per_slope = config_.beam_mm / kFullWidths / kBlurStepMm;
  const auto level = static_cast<float>(blurs_per_slope * std::sin(current_.angle_rad));
  const auto per_mm =
      static_cast<float>(blurs_per_slope * std::cos(current_.angle_rad) / (2 * kSlopeReachMm));
  const std::uint8_t* const factors = speckle_.row(row + static_cast<std::uint32_t>(speckle_roll >> 32));
  const auto rolled = static_cast<std::uint32_t>(speckle_roll);
  constexpr auto kPerMm = static_cast<float>(1 / kEchoStepMm);
  const auto offset = static_cast<float>((at.y_mm + kEchoBeforeMm) / kEchoStepMm);
  constexpr auto kLast = static_cast<float>(kEchoEntries - 1);
  for (std::uint32_t i = 0; i < surface_mm.size(); ++i) {
    const float entry = std::clamp(offset - surface_mm[i] * kPerMm, 0.0F, kLast);
    const float slant = std::abs(level + per_mm * (above_mm[i] - below_mm[i]));
    const auto blur = static_cast<std::uint32_t>(std::min(slant + 0.5F, kBlurs - 0.5F));
    const std::uint32_t mean = echo_[blur * kEchoEntries + static_cast<std::uint32_t>(entry)];
    const std::uint32_t factor = factors[(rolled + first + i) % SpeckleTile::kSide];
    const std::uint32_t grey = (mean * factor + SpeckleTile::kOne / 2) / SpeckleTile::kOne;
    pixels[first + i] = static_cast<std::uint8_t>(std::min(grey, 255U));
  }
}

}  // namespace fanlight
