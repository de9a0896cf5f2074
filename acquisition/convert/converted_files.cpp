// SPDX-License-Identifier: Apache-2.0
#include "acquisition/convert/converted_files.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cstring>
#include <ctime>
#include <memory>

#include "acquisition/convert/new_file.hpp"
#include "acquisition/sequence/plus_fields.hpp"

namespace fanlight {

namespace {

Result<void> write_whole(const std::filesystem::path& path, std::string_view header,
                         std::span<const std::uint8_t> bytes) {
  NewFile file(path);
  if (auto done = file.create(); !done) return done;
  if (auto done = file.write(header); !done) return done;
  if (auto done = file.write(bytes); !done) return done;
  return file.finish();
}

template <typename T>
void put(std::string& header, std::size_t offset, T value) {
  static_assert(std::endian::native == std::endian::little);
  std::memcpy(header.data() + offset, &value, sizeof value);
}

/// 348 bytes of nifti_1_header and 4 of an empty extension.
std::string nifti_header(const GridVolume& grid) {
  std::string header(352, '\0');
  put<std::int32_t>(header, 0, 348);  // sizeof_hdr
  put<std::int16_t>(header, 40, 3);   // dim[0]: axes
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(header, 42 + 2 * axis, static_cast<std::int16_t>(grid.size[axis]));  // dim[1..3]
    put(header, 80 + 4 * axis, static_cast<float>(grid.spacing_mm));         // pixdim[1..3]
  }
  for (std::size_t axis = 3; axis < 7; ++axis) put<std::int16_t>(header, 42 + 2 * axis, 1);
  put<float>(header, 76, 1);         // pixdim[0]
  put<std::int16_t>(header, 70, 2);  // datatype: unsigned char
  put<std::int16_t>(header, 72, 8);  // bitpix
  put<float>(header, 108, 352);      // vox_offset
  put<float>(header, 112, 1);        // scl_slope
  header[123] = 2;                   // xyzt_units: mm
  const std::string_view description = "Fanlight, axes of the transducer";
  std::memcpy(header.data() + 148, description.data(), description.size());
  put<std::int16_t>(header, 254, 1);  // sform_code: scanner
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float sign = axis < 2 ? -1.0F : 1.0F;  // left to right, posterior to anterior
    put(header, 280 + 16 * axis + 4 * axis, sign * static_cast<float>(grid.spacing_mm));
    put(header, 280 + 16 * axis + 12, sign * static_cast<float>(grid.origin_mm[axis]));
  }
  std::memcpy(header.data() + 344, "n+1", 4);
  return header;
}

Result<std::string> gzipped(std::string_view header, std::span<const std::uint8_t> voxels) {
  z_stream stream{};
  constexpr int kGzip = MAX_WBITS + 16;
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    return Error{ErrorCode::kUnavailable, "zlib cannot start, expected free memory"};
  std::string packed;
  std::string chunk(std::size_t{1} << 20, '\0');
  const auto add = [&](const void* bytes, std::size_t size, bool last) {
    const auto* next = static_cast<const Bytef*>(bytes);
    do {
      const auto part = static_cast<uInt>(std::min<std::size_t>(size, 1U << 30));
      stream.next_in = const_cast<Bytef*>(next);
      stream.avail_in = part;
      next += part;
      size -= part;
      do {
        stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
        stream.avail_out = static_cast<uInt>(chunk.size());
        deflate(&stream, last && size == 0 ? Z_FINISH : Z_NO_FLUSH);
        packed.append(chunk, 0, chunk.size() - stream.avail_out);
      } while (stream.avail_out == 0);
    } while (size > 0);
  };
  add(header.data(), header.size(), false);
  add(voxels.data(), voxels.size(), true);
  deflateEnd(&stream);
  return packed;
}

/// The header's lines "Name = value" as NRRD's "Name:=value".
std::string as_pairs(std::string_view lines) {
  std::string pairs;
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    const std::size_t equals = line.find(" = ");
    if (equals == std::string_view::npos) continue;
    pairs += fmt::format("{}:={}\n", line.substr(0, equals), line.substr(equals + 3));
  }
  return pairs;
}

/// Those of a PLUS header that a NRRD header has no field of its own for.
std::string own_pairs(const RecordingFacts& facts) {
  std::string kept;
  std::string_view lines;
  const std::string header = plus_header(facts, {});
  for (lines = header; !lines.empty();) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    if (line.starts_with("Fanlight") || line.starts_with("Ultrasound")) kept += fmt::format("{}\n", line);
  }
  return as_pairs(kept);
}

Result<std::unique_ptr<ReplaySource>> open(const Recording::Config& recording) {
  return ReplaySource::create({.recording = recording,
                               .pace = ReplaySource::Pace::kAsFastAsTaken,
                               .ending = ReplaySource::Ending::kOnce});
}

}  // namespace

Result<void> write_grid_nrrd(const std::filesystem::path& path, const GridVolume& grid) {
  const double step = grid.spacing_mm;
  const std::string header = fmt::format(
      "NRRD0005\n"
      "# Fanlight; x, y, z of the transducer as left, posterior, superior\n"
      "type: unsigned char\n"
      "dimension: 3\n"
      "space: left-posterior-superior\n"
      "sizes: {} {} {}\n"
      "space directions: ({},0,0) (0,{},0) (0,0,{})\n"
      "kinds: domain domain domain\n"
      "space units: \"mm\" \"mm\" \"mm\"\n"
      "space origin: ({},{},{})\n"
      "encoding: raw\n"
      "FanlightAxes:=transducer\n\n",
      grid.size[0], grid.size[1], grid.size[2], step, step, step, grid.origin_mm[0], grid.origin_mm[1],
      grid.origin_mm[2]);
  return write_whole(path, header, grid.voxels);
}

Result<void> write_grid_nifti(const std::filesystem::path& path, const GridVolume& grid) {
  const std::string header = nifti_header(grid);
  if (path.extension() != ".gz") return write_whole(path, header, grid.voxels);
  const auto packed = gzipped(header, grid.voxels);
  if (!packed) return packed.error();
  return write_whole(path, *packed, {});
}

Result<void> write_sequence_nrrd(const std::filesystem::path& path, const Recording::Config& recording,
                                 const Progress& progress) {
  auto source = open(recording);
  if (!source) return source.error();
  RecordingFacts facts = facts_of((*source)->description());
  const RecordedStream* const stream = (*source)->recording().stream();
  if (stream != nullptr) facts.source = stream->facts.source;
  facts.begun_utc_s = stream != nullptr ? stream->facts.begun_utc_s : std::time(nullptr);
  // The header comes first and describes every frame: a pass for the stamps, and one for the pixels.
  std::string lines;
  std::uint64_t frames = 0;
  std::int64_t first_time_ns = 0;
  double time_s = 0;
  for (;;) {
    const auto stamp = (*source)->next_frame({});
    if (!stamp) return stamp.error();
    if (!*stamp) break;
    if (frames == 0) first_time_ns = (*stamp)->capture_time_ns;
    time_s = add_plus_frame(lines, frames++, facts, {.stamp = **stamp, .fault = (*source)->known_fault()},
                            first_time_ns, time_s);
  }
  NewFile file(path);
  if (auto done = file.create(); !done) return done;
  const std::string header = fmt::format(
      "NRRD0005\ntype: unsigned char\ndimension: 3\nsizes: {} {} {}\nkinds: domain domain list\nencoding: "
      "raw\n{}{}\n",
      facts.geometry.columns, facts.geometry.rows, frames, own_pairs(facts), as_pairs(lines));
  if (auto done = file.write(header); !done) return done;

  source = open(recording);
  if (!source) return source.error();
  std::vector<std::uint8_t> pixels(facts.geometry.frame_bytes());
  for (std::uint64_t frame = 0; frame < frames; ++frame) {
    const auto stamp = (*source)->next_frame({});
    if (!stamp) return stamp.error();
    if (!*stamp)
      return Error{ErrorCode::kBadInput,
                   "the recording has become shorter, expected one that does not change"};
    if ((*source)->known_fault() != FrameFault::kNone) {
      std::ranges::fill(pixels, 0);
    } else if ((*source)->read_pixels(pixels, {}) != FrameFault::kNone) {
      const auto failed = (*source)->next_frame({});
      return failed ? Error{ErrorCode::kBadInput, "a frame could not be read, expected a whole recording"}
                    : failed.error();
    }
    if (auto done = file.write(pixels); !done) return done;
    if (!progress((static_cast<double>(frame) + 1) / static_cast<double>(frames)))
      return Error{ErrorCode::kStopped, "the conversion was stopped"};
  }
  // Behind the last frame the source judges the checksum.
  if (const auto end = (*source)->next_frame({}); !end) return end.error();
  return file.finish();
}

}  // namespace fanlight
