// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <cstdlib>
#include <string>
#include <string_view>

#include "tests/support/igs_file.hpp"

namespace fanlight::test {

/// Bytes as a gzip file. Needs ZLIB::ZLIB.
inline std::string gzipped(std::string_view bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    std::abort();
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) std::abort();
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// The header of a NRRD sequence with the fields of `file`, without the empty line at its end. `fields`:
/// lines of the format's own besides dimension and kinds, such as "type: uint8\n".
inline std::string nrrd_header(const NamedFile& file, std::string_view fields) {
  std::string text = fmt::format("NRRD0004\ndimension: 3\nsizes: {} {} {}\nkinds: domain domain list\n{}",
                                 file.columns, file.rows, file.frames.size(), fields);
  for (const auto& [name, value] : file.header) {
    if (name == "UltrasoundImageOrientation")
      text += fmt::format("ultrasound image orientation:={}\n", value);
    if (name == "UltrasoundImageType") text += fmt::format("ultrasound image type:={}\n", value);
    if (name.starts_with("Fanlight")) text += fmt::format("{}:={}\n", name, value);
  }
  for (std::size_t frame = 0; frame < file.frames.size(); ++frame) {
    for (const auto& [name, value] : file.frames[frame]) {
      text += fmt::format("Seq_Frame{:04}_{}:={}\n", frame, name == "ImageStatus" ? "Status" : name, value);
    }
  }
  return text;
}

}  // namespace fanlight::test
