// SPDX-License-Identifier: Apache-2.0
#include "server/http/recording_watch.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <nlohmann/json.hpp>

namespace fanlight {

void RecordingWatch::update() {
  const RecordingProxy::News news = dependencies_.proxy.update();
  const RecordingStatus& status = dependencies_.proxy.status();
  if (news.ended) tell_end(status);
  if (!news.changed) return;
  if (!status.trouble.empty()) spdlog::error("nothing is recorded until there is room: {}", status.trouble);
  dependencies_.sessions.recording_changed();
}

void RecordingWatch::tell_end(const RecordingStatus& status) {
  const std::string file = std::filesystem::path(status.last_file).filename().string();
  const bool done = status.last_trouble.empty();
  dependencies_.audit.note({.name = "fanlight"},
                           {.what = "recording", .result = done ? "finished" : status.last_trouble},
                           {{"file", file}, {"frames", status.last_frames}});
  if (done) {
    spdlog::info("recorded {} frames in {:.1f} s to {}", status.last_frames, status.last_duration_s, file);
  } else {
    spdlog::error("{} was not finished: {}", file, status.last_trouble);
  }
}

}  // namespace fanlight
