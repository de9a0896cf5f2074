// SPDX-License-Identifier: Apache-2.0
#include "acquisition/convert/new_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {
constexpr mode_t kOwnerOnly = 0600;
}

Result<void> NewFile::create() {
  return as_result(file_.create_unnamed(path_, kOwnerOnly));
}
Result<void> NewFile::write(std::string_view bytes) {
  return as_result(write_all(file_.descriptor(), bytes));
}
Result<void> NewFile::finish() {
  if (auto synced = as_result(file_.sync()); !synced) return synced;
  return as_result(file_.rename_if_free(path_));
}

Result<void> NewFile::as_result(int failure) const {
  if (failure == 0) return {};
  if (failure == EEXIST) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} exists already, expected a new name", shown(path_))};
  }
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} could not be written ({}), expected an existing folder with free space",
                           shown(path_), std::generic_category().message(failure))};
}

}  // namespace fanlight
