// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/segment_paths.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

#include "acquisition/record/recording_names.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kInfix = ".rec-";
constexpr std::string_view kFramesEnd = ".frames";
constexpr std::string_view kPixelsEnd = ".pixels";
constexpr std::string_view kPicturesEnd = ".pictures";
constexpr std::string_view kFinishedEnd = ".rec-finished";

/// Names of the files in a folder, as far as it can be read.
std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code failure;
  std::filesystem::directory_iterator entry(folder, failure);
  for (; !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure))
    names.push_back(entry->path().filename().string());
  return names;
}

std::filesystem::path mark_of(const std::filesystem::path& recording) {
  return recording.string() + std::string(kFinishedEnd);
}

/// Whether the mark is a second name of the recording's file, in the form that it has.
bool is_finished(const std::filesystem::path& recording) {
  std::filesystem::path pair = recording;
  pair.replace_extension(".mhd");
  const std::filesystem::path mark = mark_of(recording);
  return same_file(mark, recording) || same_file(mark, pair);
}

}  // namespace

RecordingLock::RecordingLock(const std::filesystem::path& recording)
    : path_(recording.string() + ".rec-lock"),
      file_(open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)),
      held_(file_ < 0 || flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) {}

RecordingLock::~RecordingLock() {
  if (held_ && file_ >= 0) unlink(path_.c_str());
  if (file_ >= 0) close(file_);
}

SegmentPaths segment_paths(const std::filesystem::path& recording, std::uint32_t number) {
  const std::string begin = fmt::format("{}{}{:04}", recording.string(), kInfix, number);
  return {.frames = begin + std::string(kFramesEnd),
          .pixels = begin + std::string(kPixelsEnd),
          .pictures = begin + std::string(kPicturesEnd)};
}

std::vector<SegmentPaths> segments_of(const std::filesystem::path& recording) {
  std::vector<std::uint32_t> numbers;
  const std::string begin = recording.filename().string() + std::string(kInfix);
  const auto folder = recording.has_parent_path() ? recording.parent_path() : std::filesystem::path(".");
  for (const std::string& name : names_in(folder)) {
    if (!name.starts_with(begin) || !name.ends_with(kFramesEnd)) continue;
    const std::string_view middle =
        std::string_view(name).substr(begin.size(), name.size() - begin.size() - kFramesEnd.size());
    if (const auto number = number_in<std::uint32_t>(middle)) numbers.push_back(*number);
  }
  std::ranges::sort(numbers);
  std::vector<SegmentPaths> segments;
  segments.reserve(numbers.size());
  for (const std::uint32_t number : numbers) segments.push_back(segment_paths(recording, number));
  return segments;
}

bool rename_segments(std::vector<SegmentPaths>& segments, const std::filesystem::path& recording) {
  std::uint32_t number = 0;
  for (SegmentPaths& each : segments) {
    const SegmentPaths next = segment_paths(recording, ++number);
    // The one that names the others goes first: without it the others are nothing.
    if (rename(each.frames.c_str(), next.frames.c_str()) != 0) return false;
    each.frames = next.frames;
    if (rename(each.pixels.c_str(), next.pixels.c_str()) != 0) return false;
    each.pixels = next.pixels;
    if (rename(each.pictures.c_str(), next.pictures.c_str()) == 0) each.pictures = next.pictures;
  }
  return true;
}

std::vector<std::filesystem::path> unfinished_recordings(const std::filesystem::path& folder) {
  std::set<std::filesystem::path> found;
  std::error_code failure;
  for (const std::string& name : names_in(folder)) {
    const auto infix = name.rfind(kInfix);
    if (infix == std::string::npos || !name.ends_with(kFramesEnd)) continue;
    const std::filesystem::path recording = folder / name.substr(0, infix);
    if (!std::filesystem::exists(recording, failure) && !is_finished(recording)) found.insert(recording);
  }
  return {found.begin(), found.end()};
}

void remove_segments(const std::vector<SegmentPaths>& segments) {
  std::error_code gone;
  for (const SegmentPaths& each : segments) {
    // The one that names the others goes last.
    std::filesystem::remove(each.pictures, gone);
    std::filesystem::remove(each.pixels, gone);
    std::filesystem::remove(each.frames, gone);
  }
}

std::filesystem::path finished_mark(const SegmentPaths& segment) {
  const std::string frames = segment.frames.string();
  return mark_of(frames.substr(0, frames.rfind(kInfix)));
}

bool remove_left_overs(const std::filesystem::path& recording) {
  const bool finished = is_finished(recording);
  if (finished) remove_segments(segments_of(recording));
  // Without its file it is what a kill before the naming left, or what a person has deleted.
  std::error_code failure;
  const std::filesystem::path mark = mark_of(recording);
  if (finished || std::filesystem::hard_link_count(mark, failure) == 1)
    std::filesystem::remove(mark, failure);
  return finished;
}

std::vector<std::filesystem::path> recordings_with_left_overs(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  for (const std::string& name : names_in(folder)) {
    if (!name.ends_with(kFinishedEnd)) continue;
    found.push_back(folder / name.substr(0, name.size() - kFinishedEnd.size()));
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace fanlight
