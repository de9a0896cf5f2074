// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// Size of a picture file. From the file: any value is possible.
struct ImageShape {
  int width = 0;
  int height = 0;
  int depth = 0;  ///< planes of a volume, else 1
  int channels = 0;
  unsigned bytes_per_value = 0;  ///< 1 or 2, of this machine's byte order; 2 also for floats
};

/// A picture file that is open. One thread.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual ImageShape shape() const = 0;
  /// Reads height x width x channels values of 1 or 2 bytes. The error's message is the library's own.
  virtual Result<void> read(unsigned bytes_per_value, std::span<std::uint8_t> values) = 0;
};

/// Pixels in memory, and what a file says about them.
struct ImageToWrite {
  using Value = std::variant<std::string, float, std::array<float, 16>>;

  int width = 0;
  int height = 0;
  int channels = 0;  ///< 1: depth, in a channel named Z
  bool floats = false;
  const void* pixels = nullptr;  ///< height x width, row major
  std::ptrdiff_t pixel_bytes = 0;
  std::vector<std::pair<std::string, Value>> attributes;
};

/// Reads and writes pictures in files, by OpenImageIO.
class ImageLibrary {
 public:
  virtual ~ImageLibrary() = default;
  /// The error's message is the library's own.
  virtual Result<std::unique_ptr<ImageReader>> open(const std::string& path) = 0;
  /// Whether the ending of a file name is one of a picture format.
  virtual bool writes(const std::string& name) = 0;
  /// The bytes of a file in the format of the name's ending. The error's message is the library's own.
  virtual Result<std::vector<std::uint8_t>> encode(const std::string& name, const ImageToWrite& image) = 0;
};

/// Loads libfanlight-images.so at the first call, and keeps it: with it come some 230 libraries (films, maps,
/// volumes), which take ten times as long to load as everything else that the program needs
/// (decisions/006-openimageio-on-demand.md). kUnavailable: it is missing, or of another version. Any thread.
Result<ImageLibrary*> image_library();

}  // namespace fanlight
