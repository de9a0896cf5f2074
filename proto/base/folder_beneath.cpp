// SPDX-License-Identifier: Apache-2.0
#include "proto/base/folder_beneath.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace fanlight {

namespace {

// Not openat2() with RESOLVE_BENEATH: some containers forbid it, and links are refused altogether.
constexpr int kFolder = O_PATH | O_DIRECTORY | O_CLOEXEC;

/// ELOOP for a link, instead of the ENOTDIR that Linux gives for it.
int failure_at(int folder, const std::filesystem::path& part, int failure) {
  struct stat status {};
  const bool is_link =
      ::fstatat(folder, part.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(status.st_mode);
  return is_link ? ELOOP : failure;
}

}  // namespace

FolderBeneath::~FolderBeneath() {
  if (folder_ >= 0) ::close(folder_);
}

int FolderBeneath::open(const std::filesystem::path& root, const std::filesystem::path& path,
                        Missing missing) {
  const std::filesystem::path beneath = path.lexically_relative(root);
  const bool goes_up = std::ranges::any_of(beneath, [](const auto& part) { return part == ".."; });
  if (beneath.empty() || !beneath.has_filename() || goes_up) return EINVAL;
  int folder = ::open(root.c_str(), kFolder);
  if (folder < 0) return errno;
  for (const std::filesystem::path& part : beneath.parent_path()) {
    if (missing == Missing::kMake) static_cast<void>(::mkdirat(folder, part.c_str(), 0777));
    const int next = ::openat(folder, part.c_str(), kFolder | O_NOFOLLOW);
    const int failure = next < 0 ? failure_at(folder, part, errno) : 0;
    ::close(std::exchange(folder, next));
    if (failure != 0) return failure;
  }
  if (folder_ >= 0) ::close(folder_);
  folder_ = folder;
  file_ = beneath.filename();
  return 0;
}

std::filesystem::path FolderBeneath::name() const {
  return std::filesystem::path(fmt::format("/proc/self/fd/{}", folder_)) / file_;
}

}  // namespace fanlight
