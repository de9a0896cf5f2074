// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/description_file.hpp"

#include <spdlog/spdlog.h>

#include <system_error>

#include "proto/base/file_replacement.hpp"

namespace fanlight {

void DescriptionFile::write(const std::string& text) {
  if (path_.empty()) return;
  const auto written = std::make_shared<Result<void>>();
  executor_(
      EncoderLane::kHeavy,
      [written, path = path_, text, newest = newest_, version = ++newest_->version] {
        const std::scoped_lock one_by_one(newest->writing);
        if (newest->version != version) return;
        *written = replace_file(path, text, {.mode = 0600});
        // Where the stream ended meanwhile, its file was removed before it was there.
        std::error_code none;
        if (newest->version != version) std::filesystem::remove(path, none);
      },
      [written] {
        if (!*written)
          spdlog::error("the description of the RTP stream was not written: {}", written->error().message);
      });
}

void DescriptionFile::remove() {
  ++newest_->version;
  std::error_code none;
  if (!path_.empty()) std::filesystem::remove(path_, none);
}

}  // namespace fanlight
