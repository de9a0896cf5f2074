// SPDX-License-Identifier: Apache-2.0
#include "server/service/preset_file.hpp"

#include <spdlog/spdlog.h>

#include <string>
#include <utility>
#include <vector>

namespace fanlight {

PresetFile::PresetFile(std::filesystem::path path, PresetStore& presets, Executor executor)
    : path_(std::move(path)),
      presets_(presets),
      file_(path_, {.name = "the presets", .text = [&presets] { return presets.json(); }},
            std::move(executor)) {}

void PresetFile::load() {
  const std::vector<std::string> troubles = presets_.load(path_);
  if (troubles.empty()) return;
  const std::string aside = copied_aside(path_);
  for (const std::string& trouble : troubles)
    spdlog::warn("{}{}", trouble, aside.empty() ? "" : "; the file as it was is " + aside);
}

}  // namespace fanlight
