// SPDX-License-Identifier: Apache-2.0
#include "server/service/preset_file.hpp"

#include <spdlog/spdlog.h>

#include <memory>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

#include "proto/base/file_replacement.hpp"

namespace fanlight {

PresetFile::PresetFile(std::filesystem::path path, PresetStore& presets, Executor executor)
    : path_(std::move(path)), presets_(presets), executor_(std::move(executor)) {}

void PresetFile::load() {
  const std::vector<std::string> troubles = presets_.load(path_);
  if (troubles.empty()) return;
  const std::string aside = path_.string() + ".unread";
  std::error_code failure;
  std::filesystem::copy_file(path_, aside, std::filesystem::copy_options::overwrite_existing, failure);
  for (const std::string& trouble : troubles)
    spdlog::warn("{}{}", trouble, failure ? "" : "; the file as it was is " + aside);
}

void PresetFile::presets_changed() {
  if (path_.empty()) return;
  unwritten_ = true;
  if (!writing_) write();
}

void PresetFile::finish() {
  if (unwritten_) save(presets_.json());
}

bool PresetFile::save(const std::string& text) const {
  try {
    std::error_code none;
    std::filesystem::create_directories(path_.parent_path(), none);  // where it fails, so does the file
    const auto written = replace_file(path_, text);
    if (!written) spdlog::error("the presets could not be saved: {}", written.error().message);
    return static_cast<bool>(written);
  } catch (const std::bad_alloc&) {
    return false;  // the next change, or the end, tries again
  }
}

void PresetFile::write() {
  const auto saved = std::make_shared<bool>(false);
  executor_(
      EncoderLane::kHeavy, [this, saved, text = presets_.json()] { *saved = save(text); },
      [this, saved] {
        writing_ = false;
        if (!*saved) {
          unwritten_ = true;
        } else if (unwritten_) {
          write();
        }
      });
  writing_ = true;
  unwritten_ = false;
}

}  // namespace fanlight
