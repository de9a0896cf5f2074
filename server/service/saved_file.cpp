// SPDX-License-Identifier: Apache-2.0
#include "server/service/saved_file.hpp"

#include <spdlog/spdlog.h>

#include <memory>
#include <new>
#include <system_error>
#include <utility>

#include "proto/base/file_replacement.hpp"

namespace fanlight {

SavedFile::SavedFile(std::filesystem::path path, Content content, Executor executor)
    : path_(std::move(path)), content_(std::move(content)), executor_(std::move(executor)) {}

void SavedFile::changed() {
  unwritten_ = true;
  if (!writing_) write();
}

void SavedFile::finish() {
  if (unwritten_) (void)save(content_.text());
}

Result<void> SavedFile::save(const std::string& text) const {
  try {
    std::error_code none;
    std::filesystem::create_directories(path_.parent_path(), none);  // where it fails, so does the file
    auto written = replace_file(path_, text, {.mode = content_.mode});
    if (!written) spdlog::error("{} could not be saved: {}", content_.name, written.error().message);
    return written;
  } catch (const std::bad_alloc&) {
    // The next change, or the end, tries again.
    return Error{ErrorCode::kUnavailable, "there is no memory to write the file"};
  }
}

void SavedFile::write() {
  const auto saved = std::make_shared<Result<void>>();
  executor_(
      EncoderLane::kHeavy, [this, saved, text = content_.text()] { *saved = save(text); },
      [this, saved] {
        writing_ = false;
        const bool changed_again = unwritten_;
        unwritten_ |= !*saved;
        if (content_.written) content_.written(*saved);
        if (*saved && changed_again && !writing_) write();
      });
  writing_ = true;
  unwritten_ = false;
}

std::string copied_aside(const std::filesystem::path& path) {
  const std::string aside = path.string() + ".unread";
  std::error_code failure;
  std::filesystem::copy_file(path, aside, std::filesystem::copy_options::overwrite_existing, failure);
  return failure ? "" : aside;
}

}  // namespace fanlight
