// SPDX-License-Identifier: Apache-2.0
#include "server/service/recording_watch.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <nlohmann/json.hpp>

namespace fanlight {

bool RecordingWatch::update() {
  const RecordingProxy::News news = recording_.update();
  const RecordingStatus& status = recording_.status();
  if (news.ended) report_end(status);
  if (!news.changed) return news.read;
  if (!status.trouble.empty()) spdlog::error("nothing is recorded until there is room: {}", status.trouble);
  sessions_.notify(Notice::kRecording);
  return true;
}

void RecordingWatch::report_end(const RecordingStatus& status) {
  const std::string file = std::filesystem::path(status.last_file).filename().string();
  const bool done = status.last_trouble.empty();
  audit_.note({.name = "fanlight"},
              {.what = "recording",
               .result = !done                     ? status.last_trouble
                         : status.last_was_cut_off ? "finished after it was cut off"
                                                   : "finished"},
              {{"file", file}, {"frames", status.last_frames}});
  if (done) {
    spdlog::info("{} has {} frames in {:.1f} s{}", file, status.last_frames, status.last_duration_s,
                 status.last_was_cut_off ? "; it was cut off, and is finished now" : "");
  } else {
    spdlog::error("{} was not finished: {}", file, status.last_trouble);
  }
}

}  // namespace fanlight
