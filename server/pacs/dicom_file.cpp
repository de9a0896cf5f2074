// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/dicom_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>

#include "proto/base/printable.hpp"

namespace fanlight {

Result<bool> is_dicom_file(const std::filesystem::path& path) {
  constexpr std::size_t kPreambleBytes = 128;
  constexpr std::string_view kMagic = "DICM";
  std::array<char, kPreambleBytes + kMagic.size()> head{};
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const ssize_t size = file < 0 ? -1 : read(file, head.data(), head.size());
  const int failure = errno;
  if (file >= 0) close(file);
  if (size < 0) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} cannot be read ({}), expected a file that this user may read",
                             printable(path.string()), std::generic_category().message(failure))};
  }
  return static_cast<std::size_t>(size) == head.size() &&
         std::string_view(head.data() + kPreambleBytes, kMagic.size()) == kMagic;
}

}  // namespace fanlight
