// SPDX-License-Identifier: Apache-2.0
#include "server/service/saved_file.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <new>
#include <system_error>
#include <utility>

namespace fanlight {

namespace {

/// But for names, owner and mode: a backup may link or chmod it.
bool is_same_file(const FileVersion& one, const FileVersion& other) {
  return one.device == other.device && one.inode == other.inode && one.bytes == other.bytes &&
         one.written_ns == other.written_ns;
}

}  // namespace

SavedFile::SavedFile(std::filesystem::path path, Content content, Executor executor)
    : path_(std::move(path)), content_(std::move(content)), executor_(std::move(executor)) {
  on_disk_->version = file_version(path_);
}

void SavedFile::changed() {
  unwritten_ = content_.snapshot();
  if (!writing_) write();
}

void SavedFile::finish() {
  if (!unwritten_) return;
  (void)save(path_, content_, unwritten_(), ++number_, *on_disk_);
  unwritten_ = nullptr;
}

Result<void> SavedFile::save(const std::filesystem::path& path, const Content& content,
                             const std::string& text, std::uint64_t number, OnDisk& on_disk) {
  const std::scoped_lock lock(on_disk.mutex);
  if (number < on_disk.newest) return {};  // finish() has written a later one
  on_disk.newest = number;
  if (content.respects_others && !is_same_file(file_version(path), on_disk.version)) {
    const Error changed{
        ErrorCode::kBadInput,
        fmt::format("{}: another program has changed it, expected it as this server left it", path.string())};
    spdlog::error("{} could not be saved: {}", content.name, changed.message);
    return changed;
  }
  std::error_code none;
  std::filesystem::create_directories(path.parent_path(), none);  // where it fails, so does the file
  auto written = replace_file(path, text, content.access);
  if (!written) spdlog::error("{} could not be saved: {}", content.name, written.error().message);
  on_disk.version = file_version(path);
  return written;
}

void SavedFile::write() {
  const auto saved = std::make_shared<Result<void>>();
  executor_(
      EncoderLane::kHeavy,
      [saved, path = path_, content = content_, make = unwritten_, number = ++number_, on_disk = on_disk_] {
        try {
          *saved = save(path, content, make(), number, *on_disk);
        } catch (const std::bad_alloc&) {
          *saved = Error{ErrorCode::kUnavailable, "there is no memory to write the file"};
        }
      },
      [this, saved, make = unwritten_] {
        writing_ = false;
        const bool changed_again = static_cast<bool>(unwritten_);
        // The next change, or the end, tries again.
        if (!*saved && !changed_again) unwritten_ = make;
        if (content_.written) content_.written(*saved);
        if (*saved && changed_again && !writing_) write();
      });
  writing_ = true;
  unwritten_ = nullptr;
}

}  // namespace fanlight
