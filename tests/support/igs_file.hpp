// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fanlight::test {

/// Builds a PLUS/IGSIO sequence file. It is valid unless a test changes it. Needs ZLIB::ZLIB.
struct NamedFile {
  using Fields = std::vector<std::pair<std::string, std::string>>;  ///< name and value, in order

  std::uint32_t columns = 8;
  std::uint32_t rows = 6;
  bool compressed = true;
  Fields header = {{"ObjectType", "Image"},
                   {"NDims", "3"},
                   {"BinaryData", "True"},
                   {"ElementType", "MET_UCHAR"},
                   {"Kinds", "domain domain list"},
                   {"UltrasoundImageOrientation", "MFA"},
                   {"UltrasoundImageType", "BRIGHTNESS"}};
  std::vector<Fields> frames;        ///< names without "Seq_Frame0000_"
  std::vector<std::uint8_t> pixels;  ///< frames x rows x columns

  static void set(Fields& fields, std::string_view name, std::string value) {
    const auto found = std::ranges::find(fields, name, &Fields::value_type::first);
    if (found == fields.end()) {
      fields.emplace_back(name, std::move(value));
    } else {
      found->second = std::move(value);
    }
  }
  static void remove(Fields& fields, std::string_view name) {
    std::erase_if(fields, [name](const auto& field) { return field.first == name; });
  }
  void set_all(std::string_view name, const std::string& value) {
    for (Fields& fields : frames) set(fields, name, value);
  }
  void remove_all(std::string_view name) {
    for (Fields& fields : frames) remove(fields, name);
  }

  /// The pixels as stored in the file: compressed with zlib if `compressed`.
  std::string payload() const {
    if (!compressed) return {pixels.begin(), pixels.end()};
    uLongf size = compressBound(pixels.size());
    std::string packed(size, '\0');
    if (compress(reinterpret_cast<Bytef*>(packed.data()), &size, pixels.data(), pixels.size()) != Z_OK)
      std::abort();
    packed.resize(size);
    return packed;
  }

  /// The whole file. The sizes in the header are computed here; a field of the same name in `header` replaces
  /// them.
  std::string bytes() const {
    const std::string packed = payload();
    Fields fields = {{"CompressedData", compressed ? "True" : "False"},
                     {"DimSize", fmt::format("{} {} {}", columns, rows, frames.size())}};
    if (compressed) fields.emplace_back("CompressedDataSize", fmt::format("{}", packed.size()));
    for (const auto& [name, value] : header) set(fields, name, value);
    std::string text;
    for (const auto& [name, value] : fields) text += fmt::format("{} = {}\n", name, value);
    for (std::size_t frame = 0; frame < frames.size(); ++frame) {
      for (const auto& [name, value] : frames[frame]) {
        text += fmt::format("Seq_Frame{:04}_{} = {}\n", frame, name, value);
      }
    }
    return text + "ElementDataFile = LOCAL\n" + packed;
  }
};

inline void write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// A recording of `sweeps` sweeps between -angle_deg and +angle_deg in alternating direction, the first one
/// from -angle_deg to +angle_deg. The header contains the geometry. Every pixel of frame i is i + 1. Frames
/// are 0.1 s apart.
inline NamedFile fan_recording(std::uint32_t frames_per_sweep, std::uint32_t sweeps, double angle_deg) {
  NamedFile file;
  for (const auto& [name, value] : NamedFile::Fields{{"FanlightPixelWidthMm", "2.0"},
                                                     {"FanlightPixelHeightMm", "3.0"},
                                                     {"FanlightFaceColumn", "3.5"},
                                                     {"FanlightFaceRow", "-0.5"},
                                                     {"FanlightMotorRadiusMm", "28"}}) {
    file.header.emplace_back(name, value);
  }
  for (std::uint32_t i = 0; i < frames_per_sweep * sweeps; ++i) {
    const std::uint32_t sweep = i / frames_per_sweep;
    const std::uint32_t frame_index = i % frames_per_sweep;
    const double fraction = static_cast<double>(frame_index) / (frames_per_sweep - 1);
    const double angle = (sweep % 2 == 0 ? 1 : -1) * angle_deg * (2 * fraction - 1);
    file.frames.push_back({{"Timestamp", fmt::format("{:.6f}", 12.5 + 0.1 * i)},
                           {"FrameIndex", fmt::format("{}", frame_index)},
                           {"VolumeIndex", fmt::format("{}", sweep)},
                           {"MotorAngleDeg", fmt::format("{:.4f}", angle)},
                           {"ImageStatus", "OK"}});
    file.pixels.insert(file.pixels.end(), file.columns * file.rows, static_cast<std::uint8_t>(i + 1));
  }
  return file;
}

}  // namespace fanlight::test
