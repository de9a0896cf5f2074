// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// A VkPipelineCache that is kept in a file from one process to the next, so that the driver need not compile
/// the same shaders again. The file is an optimisation only: where it cannot be read or written, or does not
/// belong to this GPU and driver, pipelines are built as without it. One thread.
///
/// File: "FLPC", the CRC-32C of the payload (4 bytes, this machine's byte order), then the payload, the
/// driver's cache data. Its name contains the IDs of vendor and device. It is replaced atomically.
class PipelineCache {
 public:
  struct Config {
    std::filesystem::path folder;  ///< of the file; made where missing. Empty: no file is read or written
    /// Receives a sentence where the file cannot be used or written; may be empty.
    std::function<void(const std::string&)> log;
  };

  /// Reads the file, if there is one. Blocks on the disk.
  PipelineCache(const Gpu& gpu, Config config);

  /// Null where the driver has no cache; Vulkan accepts that.
  VkPipelineCache get() const { return cache_.get(); }

  /// Whether the driver accepted the contents of the file.
  bool loaded() const { return loaded_; }

  /// Writes the file if the cache has changed since it was read or written. Blocks on the disk and allocates:
  /// never on the hot path.
  void save();

  /// Path of the file; empty without a folder.
  const std::filesystem::path& file() const { return file_; }

 private:
  std::vector<std::uint8_t> read_file() const;
  void log(const std::string& sentence) const;

  const Gpu& gpu_;
  Config config_;
  std::filesystem::path file_;
  PipelineCacheHandle cache_;
  bool loaded_ = false;
  std::uint32_t stored_crc_ = 0;  // of the payload in the file; 0: none
  bool unwritable_ = false;       // writing failed, and is not tried again
};

/// The folder for the user's cache files from the values of XDG_CACHE_HOME and HOME, each null where unset:
/// $XDG_CACHE_HOME/fanlight, or ~/.cache/fanlight; empty where neither is an absolute path.
std::filesystem::path user_cache_folder(const char* xdg_cache_home, const char* home);

}  // namespace fanlight
