// SPDX-License-Identifier: Apache-2.0
#include "server/service/preset_file.hpp"

#include <spdlog/spdlog.h>

#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace fanlight {

PresetFile::PresetFile(std::filesystem::path path, PresetStore& presets, Executor executor)
    : path_(std::move(path)),
      presets_(presets),
      file_(path_,
            {.name = "the presets",
             .snapshot = [&presets] { return [text = presets.json()] { return text; }; }},
            std::move(executor)) {}

void PresetFile::load() {
  const std::vector<std::string> troubles = presets_.load(path_);
  if (troubles.empty()) return;
  const std::string aside = path_.string() + ".unread";
  std::error_code failure;
  std::filesystem::copy_file(path_, aside, std::filesystem::copy_options::overwrite_existing, failure);
  for (const std::string& trouble : troubles)
    spdlog::warn("{}{}", trouble, failure ? "" : "; the file as it was is " + aside);
}

}  // namespace fanlight
