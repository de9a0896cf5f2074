// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>

#include "proto/base/file_replacement.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// A file that gets its name when it is whole, and never the name of another. Its owner alone may read it: it
/// shows a patient. Errors: kInvalidArgument where the name is taken, kUnavailable where the disk refuses.
class NewFile {
 public:
  explicit NewFile(std::filesystem::path path) : path_(std::move(path)) {}

  Result<void> create();
  Result<void> write(std::string_view bytes);
  Result<void> write(std::span<const std::uint8_t> bytes) {
    return write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  Result<void> finish();

 private:
  Result<void> as_result(int failure) const;

  std::filesystem::path path_;
  ReplacementFile file_;
};

}  // namespace fanlight
