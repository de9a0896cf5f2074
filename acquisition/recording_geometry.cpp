#include "acquisition/recording_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <sstream>
#include <toml.hpp>

#include "acquisition/text.hpp"

namespace fanlight {

namespace {

struct Key {
  std::string_view name;
  std::string_view header_field;
  bool required;
  void (*set)(RecordingGeometry& into, double value);
};

constexpr Key kKeys[] = {
    {"pixel_width_mm", "FanlightPixelWidthMm", true,
     [](RecordingGeometry& into, double value) { into.geometry.pixel_width_mm = value; }},
    {"pixel_height_mm", "FanlightPixelHeightMm", true,
     [](RecordingGeometry& into, double value) { into.geometry.pixel_height_mm = value; }},
    {"face_column", "FanlightFaceColumn", true,
     [](RecordingGeometry& into, double value) { into.geometry.face_column = value; }},
    {"face_row", "FanlightFaceRow", true,
     [](RecordingGeometry& into, double value) { into.geometry.face_row = value; }},
    {"motor_radius_mm", "FanlightMotorRadiusMm", true,
     [](RecordingGeometry& into, double value) { into.geometry.motor_radius_mm = value; }},
    {"probe_radius_mm", "FanlightProbeRadiusMm", false,
     [](RecordingGeometry& into, double value) { into.geometry.sector.probe_radius_mm = value; }},
    {"sector_half_angle_deg", "FanlightSectorHalfAngleDeg", false,
     [](RecordingGeometry& into, double value) { into.geometry.sector.half_angle_deg = value; }},
    {"sector_reach_mm", "FanlightSectorReachMm", false,
     [](RecordingGeometry& into, double value) { into.geometry.sector.reach_mm = value; }},
    {"first_angle_deg", "FanlightFirstAngleDeg", false,
     [](RecordingGeometry& into, double value) { into.first_angle_deg = value; }},
    {"last_angle_deg", "FanlightLastAngleDeg", false,
     [](RecordingGeometry& into, double value) { into.last_angle_deg = value; }},
};
constexpr std::size_t kKeyCount = std::size(kKeys);

/// What one place has to say: a value per key of kKeys, or none.
struct Layer {
  std::string origin;
  std::array<std::optional<double>, kKeyCount> values{};
};

std::string key_names() {
  std::string names;
  for (const Key& key : kKeys) names += fmt::format("{}{}", names.empty() ? "" : ", ", key.name);
  return names;
}

Error bad(const std::filesystem::path& path, std::string_view wrong, std::string_view expected) {
  return {ErrorCode::kBadInput, fmt::format("{}: {}, expected {}", shown(path), wrong, expected)};
}

Result<toml::value> parse(const std::filesystem::path& path) {
  constexpr std::string_view kExpected = "lines such as motor_radius_mm = 28.0";
  // Ample for a geometry. The parser recurses into each bracket and each dot of a key, and has no bound of
  // its own: 16 000 dots overflow its stack.
  constexpr std::size_t kMostBytes = 4096;
  constexpr std::ptrdiff_t kMostBrackets = 16;
  std::string text(kMostBytes + 1, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMostBytes)
    return bad(path, fmt::format("the file is longer than {} bytes", kMostBytes), kExpected);
  const auto brackets = std::ranges::count_if(text, [](char c) { return c == '[' || c == '{'; });
  if (brackets > kMostBrackets) return bad(path, "the file is full of brackets", kExpected);
  try {
    std::istringstream stream(text);
    return toml::parse(stream, shown(path));
  } catch (const toml::exception& failure) {
    return bad(path, fmt::format("line {} is not TOML", failure.location().line()), kExpected);
  } catch (const std::exception&) {
    return bad(path, "the file is not TOML", kExpected);
  }
}

Result<Layer> read_geometry_file(const std::filesystem::path& path) {
  const auto parsed = parse(path);
  if (!parsed) return parsed.error();
  Layer layer{.origin = shown(path)};
  for (const auto& [name, value] : parsed->as_table(std::nothrow)) {
    const auto* const key = std::ranges::find(kKeys, name, &Key::name);
    if (key == std::end(kKeys)) {
      return bad(path, fmt::format("there is a key {}", in_quotes(name)), key_names());
    }
    double number = std::nan("");
    if (value.is_floating()) number = value.as_floating(std::nothrow);
    if (value.is_integer()) number = static_cast<double>(value.as_integer(std::nothrow));
    if (!std::isfinite(number)) return bad(path, fmt::format("{} is no number", name), "a number");
    layer.values[key - kKeys] = number;
  }
  return layer;
}

Result<Layer> read_header(const std::filesystem::path& path, const IgsSequence& sequence) {
  Layer layer{.origin = "the header"};
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    const auto found = sequence.fanlight_fields.find(kKeys[i].header_field);
    if (found == sequence.fanlight_fields.end()) continue;
    layer.values[i] = number_in<double>(found->second);
    if (!layer.values[i]) {
      return bad(path, fmt::format("{} is {}", kKeys[i].header_field, in_quotes(found->second)), "a number");
    }
  }
  return layer;
}

Layer read_transform(const IgsSequence& sequence) {
  Layer layer{.origin = "its ImageToReferenceTransform"};
  static_assert(kKeys[0].name == "pixel_width_mm" && kKeys[1].name == "pixel_height_mm");
  if (sequence.pixel_size) {
    layer.values[0] = sequence.pixel_size->width_mm;
    layer.values[1] = sequence.pixel_size->height_mm;
  }
  return layer;
}

}  // namespace

Result<RecordingGeometry> find_geometry(const std::filesystem::path& recording_path,
                                        const IgsSequence& sequence,
                                        const std::filesystem::path& geometry_path) {
  auto sidecar = recording_path;
  sidecar += ".toml";
  const auto& file = geometry_path.empty() ? sidecar : geometry_path;

  std::vector<Layer> layers;
  std::error_code failure;
  if (std::filesystem::is_regular_file(file, failure)) {
    auto layer = read_geometry_file(file);
    if (!layer) return layer.error();
    layers.push_back(*std::move(layer));
  } else if (!geometry_path.empty()) {
    return Error{
        ErrorCode::kNotFound,
        fmt::format("{}: there is no such file, expected a fan geometry in TOML", shown(geometry_path))};
  }
  auto header = read_header(recording_path, sequence);
  if (!header) return header.error();
  layers.push_back(*std::move(header));
  layers.push_back(read_transform(sequence));

  RecordingGeometry found;
  found.geometry.columns = sequence.columns;
  found.geometry.rows = sequence.rows;
  std::string missing;
  std::string missing_fields;
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    const auto layer =
        std::ranges::find_if(layers, [i](const Layer& each) { return each.values[i].has_value(); });
    if (layer != layers.end()) {
      kKeys[i].set(found, *layer->values[i]);
      found.values.push_back({kKeys[i].name, *layer->values[i], layer->origin});
    } else if (kKeys[i].required) {
      const std::string_view separator = missing.empty() ? "" : ", ";
      missing += fmt::format("{}{}", separator, kKeys[i].name);
      missing_fields += fmt::format("{}{}", separator, kKeys[i].header_field);
    }
  }
  if (!missing.empty()) {
    return bad(recording_path, fmt::format("the fan geometry lacks {}", missing),
               fmt::format("a value for each in {}, in a file given by --geometry, or in the header as {}",
                           shown(sidecar.filename()), missing_fields));
  }
  if (const auto checked = check(found.geometry); !checked) {
    return Error{ErrorCode::kBadInput, fmt::format("{}: {}", shown(recording_path), checked.error().message)};
  }
  return found;
}

}  // namespace fanlight
