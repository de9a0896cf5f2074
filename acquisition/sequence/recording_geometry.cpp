// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/recording_geometry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <toml.hpp>

#include "acquisition/source/printable.hpp"
#include "proto/base/toml_excess.hpp"
#include "proto/base/toml_place.hpp"

namespace fanlight {

namespace {

/// How a kind of frame uses a value.
enum class Use : std::uint8_t {
  kRequired,
  kOptional,
  kUnread,   ///< ignored: this kind of frame has no such property
  kRefused,  ///< it contradicts this kind of frame
};
using Uses = std::array<Use, 3>;  ///< by FrameKind
constexpr Uses kEveryKind = {Use::kRequired, Use::kRequired, Use::kRequired};
constexpr Uses kIfGiven = {Use::kOptional, Use::kOptional, Use::kOptional};
constexpr Uses kParallelColumns = {Use::kRequired, Use::kUnread, Use::kRequired};
constexpr Uses kCurvedArrays = {Use::kOptional, Use::kRequired, Use::kUnread};
constexpr Uses kConvexLinesAlone = {Use::kRefused, Use::kRequired, Use::kRefused};
constexpr std::string_view kSweepOrders[] = {"one-way", "to-and-fro"};
constexpr std::string_view kBeams[] = {"swept", "unknown"};
constexpr Uses kSectors = {Use::kOptional, Use::kUnread, Use::kUnread};

struct Key {
  std::string_view name;
  std::string_view header_field;
  Uses uses;
  void (*set)(RecordingGeometry& into, double value);
  std::span<const std::string_view> choices = {};  ///< the value is an index into these; empty: a number
};

constexpr Key kKeys[] = {
    {"pixel_width_mm", "FanlightPixelWidthMm", kParallelColumns,
     [](RecordingGeometry& into, double value) { into.geometry.pixel_width_mm = value; }},
    {"pixel_height_mm", "FanlightPixelHeightMm", kEveryKind,
     [](RecordingGeometry& into, double value) { into.geometry.pixel_height_mm = value; }},
    {"face_column", "FanlightFaceColumn", kEveryKind,
     [](RecordingGeometry& into, double value) { into.geometry.face_column = value; }},
    {"face_row", "FanlightFaceRow", kEveryKind,
     [](RecordingGeometry& into, double value) { into.geometry.face_row = value; }},
    {"motor_radius_mm", "FanlightMotorRadiusMm", kEveryKind,
     [](RecordingGeometry& into, double value) { into.geometry.motor_radius_mm = value; }},
    {"frame_kind", "FanlightFrameKind", kEveryKind,
     [](RecordingGeometry& into, double value) {
       into.geometry.kind = static_cast<FrameKind>(static_cast<int>(value));
     },
     kFrameKindNames},
    {"probe_radius_mm", "FanlightProbeRadiusMm", kCurvedArrays,
     [](RecordingGeometry& into, double value) { into.geometry.probe_radius_mm = value; }},
    {"line_pitch_deg", "FanlightLinePitchDeg", kConvexLinesAlone,
     [](RecordingGeometry& into, double value) { into.geometry.line_pitch_deg = value; }},
    {"sector_half_angle_deg", "FanlightSectorHalfAngleDeg", kSectors,
     [](RecordingGeometry& into, double value) { into.geometry.sector.half_angle_deg = value; }},
    {"sector_reach_mm", "FanlightSectorReachMm", kSectors,
     [](RecordingGeometry& into, double value) { into.geometry.sector.reach_mm = value; }},
    {"columns", "FanlightColumns", kIfGiven,
     [](RecordingGeometry& into, double value) { into.for_columns = value; }},
    {"rows", "FanlightRows", kIfGiven, [](RecordingGeometry& into, double value) { into.for_rows = value; }},
    {"frames", "FanlightFrames", kIfGiven,
     [](RecordingGeometry& into, double value) { into.for_frames = value; }},
    {"window_black", "FanlightWindowBlack", kIfGiven,
     [](RecordingGeometry& into, double value) { into.window_black = value; }},
    {"window_white", "FanlightWindowWhite", kIfGiven,
     [](RecordingGeometry& into, double value) { into.window_white = value; }},
    {"frames_per_second", "FanlightFramesPerSecond", kIfGiven,
     [](RecordingGeometry& into, double value) { into.frames_per_second = value; }},
    {"frames_per_sweep", "FanlightFramesPerSweep", kIfGiven,
     [](RecordingGeometry& into, double value) { into.frames_per_sweep = value; }},
    {"sweep_order", "FanlightSweepOrder", kIfGiven,
     [](RecordingGeometry& into, double value) { into.to_and_fro = value != 0; }, kSweepOrders},
    {"unscanned", "FanlightUnscanned", kSectors,
     [](RecordingGeometry& into, double value) {
       into.unscanned = static_cast<Unscanned>(static_cast<int>(value));
     },
     kUnscannedNames},
    {"beams", "FanlightBeams", kSectors,
     [](RecordingGeometry& into, double value) { into.geometry.unknown_beams = value != 0; }, kBeams},
    {"first_angle_deg", "FanlightFirstAngleDeg", kIfGiven,
     [](RecordingGeometry& into, double value) { into.first_angle_deg = value; }},
    {"last_angle_deg", "FanlightLastAngleDeg", kIfGiven,
     [](RecordingGeometry& into, double value) { into.last_angle_deg = value; }},
};
constexpr std::size_t kKeyCount = std::size(kKeys);

/// A list of angles, in a geometry file alone.
struct ListKey {
  std::string_view name;
  std::vector<double> RecordingGeometry::*list;
};
constexpr ListKey kListKeys[] = {
    {"angles_deg", &RecordingGeometry::angles_deg},
    {"sweep_starts_deg", &RecordingGeometry::sweep_starts_deg},
};

constexpr std::size_t key_index(std::string_view name) {
  return std::ranges::find(kKeys, name, &Key::name) - kKeys;
}
constexpr std::size_t kPixelWidth = key_index("pixel_width_mm");
constexpr std::size_t kPixelHeight = key_index("pixel_height_mm");
constexpr std::size_t kFrameKind = key_index("frame_kind");
constexpr std::size_t kFaceRow = key_index("face_row");
constexpr std::size_t kMotorRadius = key_index("motor_radius_mm");
constexpr std::size_t kUnscanned = key_index("unscanned");
static_assert(kPixelWidth < kKeyCount && kPixelHeight < kKeyCount && kFrameKind < kKeyCount &&
              kFaceRow < kKeyCount && kMotorRadius < kKeyCount && kUnscanned < kKeyCount);

/// The number in a text, or the index of the choice that it names.
std::optional<double> value_in(const Key& key, std::string_view text) {
  if (key.choices.empty()) return number_in<double>(text);
  const auto choice = std::ranges::find(key.choices, text);
  if (choice == key.choices.end()) return std::nullopt;
  return static_cast<double>(choice - key.choices.begin());
}

std::string shown_value(const Key& key, double value) {
  // Six digits: a header has a float as a double. Plus zero: none reads -0.
  if (key.choices.empty()) return fmt::format("{:.6g}", value + 0.0);
  return std::string(key.choices[static_cast<std::size_t>(value)]);
}

std::string expected_value(const Key& key) {
  if (key.choices.empty()) return "a number";
  const auto last = key.choices.size() - 1;
  return fmt::format("{} or {}", fmt::join(key.choices.first(last), ", "), key.choices[last]);
}

constexpr std::string_view kHeaderOrigin = "the header";
constexpr std::string_view kDefaultOrigin = "the default";

/// Values of one origin: one per key of kKeys, or none.
struct Layer {
  std::string origin;
  std::array<std::optional<double>, kKeyCount> values{};
  std::array<std::vector<double>, std::size(kListKeys)> lists{};
};

/// The first layer that has a value for the key, or nullptr.
const Layer* first_with(std::span<const Layer> layers, std::size_t key) {
  const auto found =
      std::ranges::find_if(layers, [key](const Layer& each) { return each.values[key].has_value(); });
  return found == layers.end() ? nullptr : &*found;
}

std::string key_names() {
  std::string names;
  for (const Key& key : kKeys) names += fmt::format("{}{}", names.empty() ? "" : ", ", key.name);
  for (const ListKey& key : kListKeys) names += fmt::format(", {}", key.name);
  return names;
}

/// Parses a geometry file. It is not trusted: its length and its nesting are limited. kBadInput names the
/// file and the line.
Result<toml::value> parse_geometry_toml(const std::filesystem::path& path) {
  constexpr std::string_view kExpected = "lines such as motor_radius_mm = 28.0";
  constexpr std::size_t kMostBytes = 65'536;  // far above the size of any geometry
  std::string text(kMostBytes + 1, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMostBytes)
    return bad_file(path, fmt::format("the file is longer than {} bytes", kMostBytes), kExpected);
  if (const std::string excess = toml_excess(text); !excess.empty()) return bad_file(path, excess, kExpected);
  try {
    std::istringstream stream(text);
    return toml::parse(stream, shown(path));
  } catch (const toml::syntax_error& failure) {
    return bad_file(path, fmt::format("line {} is not TOML", toml_error_line(failure)), kExpected);
  } catch (const std::exception&) {
    return bad_file(path, "the file is not TOML", kExpected);
  }
}

std::optional<double> value_of(const Key& key, const toml::value& value) {
  if (!key.choices.empty()) {
    return value.is_string() ? value_in(key, toml::get<std::string>(value)) : std::nullopt;
  }
  double number = std::nan("");
  if (value.is_floating()) number = value.as_floating(std::nothrow);
  if (value.is_integer()) number = static_cast<double>(value.as_integer(std::nothrow));
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::optional<std::vector<double>> numbers_of(const toml::value& value) {
  if (!value.is_array()) return std::nullopt;
  std::vector<double> numbers;
  for (const toml::value& each : value.as_array(std::nothrow)) {
    const Key number{};
    const auto read = value_of(number, each);
    if (!read) return std::nullopt;
    numbers.push_back(*read);
  }
  return numbers.empty() ? std::nullopt : std::optional(std::move(numbers));
}

Result<Layer> read_geometry_file(const std::filesystem::path& path) {
  const auto parsed = parse_geometry_toml(path);
  if (!parsed) return parsed.error();
  Layer layer{.origin = shown(path)};
  for (const auto& [name, value] : parsed->as_table(std::nothrow)) {
    const auto* const list = std::ranges::find(kListKeys, name, &ListKey::name);
    if (list != std::end(kListKeys)) {
      auto numbers = numbers_of(value);
      if (!numbers)
        return bad_file(path, fmt::format("{} is no list of numbers", name), "one such as [-20.0, 20.0]");
      layer.lists[list - kListKeys] = *std::move(numbers);
      continue;
    }
    const auto* const key = std::ranges::find(kKeys, name, &Key::name);
    if (key == std::end(kKeys)) {
      return bad_file(path, fmt::format("there is a key {}", in_quotes(name)), key_names());
    }
    const auto read = value_of(*key, value);
    if (!read) {
      const std::string_view wrong = key->choices.empty() ? "no number" : "none of its choices";
      return bad_file(path, fmt::format("{} is {}", name, wrong), expected_value(*key));
    }
    layer.values[key - kKeys] = read;
  }
  return layer;
}

Result<Layer> read_header(const std::filesystem::path& path, const FrameSequence& sequence) {
  Layer layer{.origin = std::string(kHeaderOrigin)};
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    const auto found = sequence.fanlight_fields.find(kKeys[i].header_field);
    if (found == sequence.fanlight_fields.end()) continue;
    layer.values[i] = value_in(kKeys[i], found->second);
    if (!layer.values[i]) {
      return bad_file(path, fmt::format("{} is {}", kKeys[i].header_field, in_quotes(found->second)),
                      expected_value(kKeys[i]));
    }
  }
  return layer;
}

Layer read_transform(const FrameSequence& sequence) {
  Layer layer{.origin = std::string(sequence.pixel_size_origin)};
  if (sequence.pixel_size) {
    layer.values[kPixelWidth] = sequence.pixel_size->width_mm;
    layer.values[kPixelHeight] = sequence.pixel_size->height_mm;
  }
  return layer;
}

Layer defaults() {
  Layer layer{.origin = std::string(kDefaultOrigin)};
  layer.values[kFrameKind] = static_cast<double>(FrameKind::kCartesian);
  return layer;
}

constexpr std::string_view kGridKeys = "window_black, window_white and unscanned alone";

/// The geometry of a grid is made, and nothing else fits it.
Result<void> check_grid_overrides(const std::filesystem::path& file, const Layer& layer,
                                  const FrameSequence& sequence) {
  if (!sequence.is_grid) return {};
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    if (!layer.values[i] || kKeys[i].name.starts_with("window_") || i == kUnscanned) continue;
    return bad_file(file, fmt::format("it gives {} for a volume on a grid", kKeys[i].name), kGridKeys);
  }
  if (std::ranges::all_of(layer.lists, &std::vector<double>::empty)) return {};
  return bad_file(file, "it gives angles for a volume on a grid", kGridKeys);
}

/// All origins of values for the recording, in order of precedence.
Result<std::vector<Layer>> read_layers(const std::filesystem::path& recording_path,
                                       const FrameSequence& sequence,
                                       const std::filesystem::path& geometry_path) {
  const auto file = geometry_path.empty() ? sidecar(recording_path) : geometry_path;
  std::vector<Layer> layers;
  std::optional<Layer> beside;
  std::error_code failure;
  if (std::filesystem::is_regular_file(file, failure)) {
    auto layer = read_geometry_file(file);
    if (!layer) return layer.error();
    if (auto fits = check_grid_overrides(file, *layer, sequence); !fits) return fits.error();
    if (geometry_path.empty()) {
      beside = *std::move(layer);
    } else {
      layers.push_back(*std::move(layer));
    }
  } else if (!geometry_path.empty()) {
    return Error{
        ErrorCode::kNotFound,
        fmt::format("{}: there is no such file, expected a fan geometry in TOML", shown(geometry_path))};
  }
  auto header = read_header(recording_path, sequence);
  if (!header) return header.error();
  layers.push_back(*std::move(header));
  const auto behind_header = static_cast<std::ptrdiff_t>(layers.size());
  if (beside) layers.push_back(*std::move(beside));
  layers.push_back(defaults());
  // Diverging lines have no pixel size that a matrix could contain.
  if (*first_with(layers, kFrameKind)->values[kFrameKind] == static_cast<double>(FrameKind::kConvexLines))
    return layers;
  const bool is_set =
      sequence.pixel_size && (sequence.pixel_size->width_mm != 1 || sequence.pixel_size->height_mm != 1);
  layers.insert(is_set ? layers.begin() + behind_header : layers.end(), read_transform(sequence));
  return layers;
}

/// Where two origins differ by more than their rounding: both, and which one is used.
std::optional<std::string> contradiction(std::span<const Layer> layers, std::size_t key) {
  constexpr double kRounding = 1e-3;
  const Layer* const used = first_with(layers, key);
  if (used == nullptr || used->origin == kDefaultOrigin) return std::nullopt;
  const double value = *used->values[key];
  for (const Layer& other : layers) {
    if (other.origin == kDefaultOrigin) break;  // what follows was never set
    if (&other == used || !other.values[key]) continue;
    const double off = std::abs(*other.values[key] - value);
    if (off <= kRounding * std::max(std::abs(value), 1e-3)) continue;
    const bool is_given = used == layers.data() && used->origin != kHeaderOrigin;
    return fmt::format("There are two values of {}: {} from {} is used, and not {} from {}{}.",
                       kKeys[key].name, shown_value(kKeys[key], value), used->origin,
                       shown_value(kKeys[key], *other.values[key]), other.origin,
                       is_given ? "" : "; a file given by --geometry counts more than both");
  }
  return std::nullopt;
}

/// What a number of degrees says that was meant as radians: lines or a sector that span almost nothing.
void add_suspicions(RecordingGeometry& found) {
  constexpr double kLeastSpanDeg = 4;
  const FanGeometry& geometry = found.geometry;
  const auto suspect = [&](std::string_view key, double value_deg, double span_deg) {
    if (span_deg >= kLeastSpanDeg || degrees(span_deg) > 180) return;
    found.suspicions.push_back(fmt::format(
        "With {} = {:.6g} the frames span {:.3g} deg. Is it in radians? {:.6g} deg would span {:.3g} deg.",
        key, value_deg, span_deg, degrees(value_deg), degrees(span_deg)));
  };
  if (geometry.polar())
    suspect("line_pitch_deg", geometry.line_pitch_deg, (geometry.columns - 1) * geometry.line_pitch_deg);
  if (geometry.sector.half_angle_deg > 0)
    suspect("sector_half_angle_deg", geometry.sector.half_angle_deg, 2 * geometry.sector.half_angle_deg);
}

/// The motor radius: from the probe face back to the axis that was fitted to the poses.
void add_fit(std::vector<Layer>& layers, const FanFit& fit) {
  const Layer* const face = first_with(layers, kFaceRow);
  const Layer* const height = first_with(layers, kPixelHeight);
  if (face == nullptr || height == nullptr) return;
  Layer layer{.origin = "the poses"};
  layer.values[kMotorRadius] = *face->values[kFaceRow] * *height->values[kPixelHeight] - fit.axis_mm;
  layers.push_back(std::move(layer));
}

/// Whether the geometry is for frames of this size and number, where it says so.
Result<void> check_size(const std::filesystem::path& path, const FrameSequence& sequence,
                        const RecordingGeometry& found) {
  const auto differs = [](const std::optional<double>& wanted, std::size_t present) {
    return wanted && *wanted != static_cast<double>(present);
  };
  const auto text = [](const std::optional<double>& wanted) {
    return wanted ? fmt::format("{}", *wanted) : std::string("any number of");
  };
  if (!differs(found.for_columns, sequence.columns) && !differs(found.for_rows, sequence.rows) &&
      !differs(found.for_frames, sequence.frames.size()))
    return {};
  return bad_file(path,
                  fmt::format("the recording has {} frames of {} columns and {} rows", sequence.frames.size(),
                              sequence.columns, sequence.rows),
                  fmt::format("{} frames of {} columns and {} rows, which its geometry is for",
                              text(found.for_frames), text(found.for_columns), text(found.for_rows)));
}

}  // namespace

std::filesystem::path sidecar(std::filesystem::path recording_path) {
  if (!recording_path.has_filename()) recording_path = recording_path.parent_path();  // "frames/"
  recording_path += ".toml";
  return recording_path;
}

Result<RecordingGeometry> find_geometry(const std::filesystem::path& recording_path,
                                        const FrameSequence& sequence,
                                        const std::filesystem::path& geometry_path,
                                        const std::optional<FanFit>& fit) {
  auto layers = read_layers(recording_path, sequence, geometry_path);
  if (!layers) return layers.error();
  if (fit) add_fit(*layers, *fit);
  const auto kind = static_cast<std::size_t>(*first_with(*layers, kFrameKind)->values[kFrameKind]);
  const std::string& kind_origin = first_with(*layers, kFrameKind)->origin;

  RecordingGeometry found;
  found.fit = fit;
  found.geometry.columns = sequence.columns;
  found.geometry.rows = sequence.rows;
  std::vector<std::string_view> missing;
  std::vector<std::string_view> missing_fields;
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    const Key& key = kKeys[i];
    const Layer* const layer = first_with(*layers, i);
    if (layer == nullptr) {
      if (key.uses[kind] != Use::kRequired) continue;
      missing.push_back(key.name);
      missing_fields.push_back(key.header_field);
    } else if (key.uses[kind] == Use::kRefused) {
      return bad_file(
          recording_path,
          fmt::format("{} gives a {} for {} frames", layer->origin, key.name, kFrameKindNames[kind]),
          fmt::format(
              "another frame_kind{}, or no {}",
              kind_origin == kDefaultOrigin
                  ? ""
                  : fmt::format(" than that of {}, which counts unless --geometry gives one", kind_origin),
              key.name));
    } else if (key.uses[kind] != Use::kUnread) {
      key.set(found, *layer->values[i]);
      found.values.push_back({key.name, shown_value(key, *layer->values[i]), layer->origin});
      if (auto sentence = contradiction(*layers, i)) found.contradictions.push_back(*std::move(sentence));
    }
  }
  for (std::size_t i = 0; i < std::size(kListKeys); ++i) {
    for (const Layer& layer : *layers) {
      const std::vector<double>& list = layer.lists[i];
      if (list.empty()) continue;
      found.*kListKeys[i].list = list;
      found.values.push_back({kListKeys[i].name, fmt::format("{} numbers", list.size()), layer.origin});
    }
  }
  if (!missing.empty()) {
    std::error_code failure;
    // Images received over a network have neither a file next to them nor a header.
    const bool is_file = std::filesystem::exists(recording_path, failure);
    const std::string beside =
        is_file ? fmt::format("{}, in ", shown(sidecar(recording_path).filename())) : "";
    Error lacks =
        bad_file(recording_path, fmt::format("the fan geometry lacks {}", fmt::join(missing, ", ")),
                 fmt::format("a value for each in {}a file given by --geometry, or in the {} as {}", beside,
                             is_file ? "header" : "metadata", fmt::join(missing_fields, ", ")));
    lacks.code = ErrorCode::kUnsupported;
    return lacks;
  }
  if (found.window_black.has_value() != found.window_white.has_value() ||
      (found.window_black && *found.window_black >= *found.window_white)) {
    return bad_file(recording_path, "the geometry has a window without a width",
                    "window_black and window_white above it, or neither");
  }
  if (const auto fits = check_size(recording_path, sequence, found); !fits) return fits.error();
  if (const auto checked = check(found.geometry); !checked) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: {}{}{}", shown(recording_path), checked.error().message,
                             found.contradictions.empty() ? "" : ". ", fmt::join(found.contradictions, " "))};
  }
  if (sequence.is_grid) found.geometry.unknown_beams = true;
  found.geometry.zero_is_unscanned = found.unscanned == Unscanned::kZero && !sequence.is_grid;
  add_suspicions(found);
  return found;
}

}  // namespace fanlight
