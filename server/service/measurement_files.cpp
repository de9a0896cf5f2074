// SPDX-License-Identifier: Apache-2.0
#include "server/service/measurement_files.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>

#include "proto/model/measurement_file.hpp"
#include "server/state/measurement_file.hpp"

namespace fanlight {

namespace {

/// 0 where it is no regular file.
std::uint64_t bytes_of(const std::filesystem::path& recording) {
  std::error_code failure;
  if (!std::filesystem::is_regular_file(recording, failure)) return 0;
  const auto bytes = std::filesystem::file_size(recording, failure);
  return failure ? 0 : bytes;
}

}  // namespace

MeasurementFiles::MeasurementFiles(std::filesystem::path played, Dependencies dependencies)
    : played_(std::move(played)), dependencies_(std::move(dependencies)) {}

void MeasurementFiles::load() {
  if (played_.empty()) return;
  const std::filesystem::path path = measurements_path_of(played_);
  Entry& entry = add(played_, 0, kNoSequence);  // before the reading: what another program writes now counts
  entry.bytes = bytes_of(played_);
  std::vector<std::string> troubles;
  if (auto text = read_measurement_file(path); !text) {
    troubles.push_back(text.error().message);
    read_trouble_ = "The measurements beside this recording cannot be read.";
  } else if (*text) {
    ReadMeasurements read = parse_measurements(**text);
    const std::uint64_t bytes = read.file.recording_bytes();
    troubles = std::move(read.troubles);
    if (bytes != 0 && entry.bytes != 0 && bytes != entry.bytes) {
      troubles = {fmt::format("they are of a recording of {} bytes, expected {}", bytes, entry.bytes)};
      read_trouble_ = "The measurements beside this recording are of another one of its name, and not shown.";
    } else {
      for (const auto& each : dependencies_.measurements.load(std::move(read.file))) troubles.push_back(each);
      if (!troubles.empty())
        read_trouble_ =
            "Not all measurements beside this recording can be read; the server's log has the reasons.";
    }
  }
  entry.signature = dependencies_.measurements.signature(entry.first_number, entry.last_number);
  if (!troubles.empty()) set_aside(path, troubles);
  shown_trouble_ = trouble();
  dependencies_.measurements.keep_with_recording(shown_trouble_);
}

/// A further name for the file: what is written later gets the name that it has.
void MeasurementFiles::set_aside(const std::filesystem::path& path,
                                 const std::vector<std::string>& troubles) {
  constexpr int kMostNames = 99;
  constexpr std::size_t kMostLines = 3;
  std::string aside;
  int failure = EEXIST;
  for (int number = 1; failure == EEXIST && number <= kMostNames; ++number) {
    aside = fmt::format("{}.unread{}", path.string(), number == 1 ? "" : fmt::format("-{}", number));
    std::error_code none;
    const bool has_it = std::filesystem::equivalent(path, aside, none);
    failure = has_it || link(path.c_str(), aside.c_str()) == 0 ? 0 : errno;
  }
  for (const std::string& trouble : std::span(troubles).first(std::min(troubles.size(), kMostLines)))
    spdlog::warn("{}: {}", path.string(), trouble);
  if (troubles.size() > kMostLines) spdlog::warn("and {} more", troubles.size() - kMostLines);
  may_write_ = failure == 0;
  if (may_write_) {
    spdlog::warn("the file as it is has the name {} too", aside);
  } else {
    spdlog::error("{} gets no further name ({}), so it is left as it is, and no measurement is saved",
                  path.string(), std::generic_category().message(failure));
    write_trouble_ = "Measurements are not saved, and last until the server stops.";
  }
}

MeasurementFiles::Entry& MeasurementFiles::add(const std::filesystem::path& recording, std::uint64_t first,
                                               std::uint64_t last) {
  if (entries_.size() >= kMostRecordings) {
    const auto idle = std::ranges::find_if(entries_, [](const Entry& each) { return !each.file->is_busy(); });
    if (idle != entries_.end()) entries_.erase(idle);
  }
  Entry& entry = entries_.emplace_back(recording, first, last);
  const std::filesystem::path path = measurements_path_of(recording);
  SavedFile::Content content{.name = "the measurements",
                             .snapshot =
                                 [this, &entry] {
                                   v1::MeasurementFile file =
                                       dependencies_.measurements.file(entry.first_number, entry.last_number);
                                   file.set_recording_bytes(entry.bytes);
                                   return [file = std::move(file)] { return measurement_file_text(file); };
                                 },
                             .access = {.mode = 0600, .beneath = path.parent_path()},
                             .respects_others = true};
  if (recording == played_) content.written = [this](const Result<void>& saved) { written(saved); };
  entry.file.emplace(path, std::move(content), dependencies_.executor);
  return entry;
}

/// The file of the recording that is played was written, or not. The log has the reason.
void MeasurementFiles::written(const Result<void>& saved) {
  if (saved) {
    write_trouble_.clear();
  } else if (saved.error().code == ErrorCode::kBadInput) {
    write_trouble_ =
        "Measurements are not saved, since another program has changed their file. "
        "They last until the server stops.";
  } else {
    write_trouble_ =
        "Measurements are not saved, since the folder of this recording cannot be written. "
        "They last until the server stops.";
  }
  show_trouble();
}

MeasurementFiles::Entry* MeasurementFiles::find(const std::filesystem::path& recording) {
  const auto found = std::ranges::find(entries_, recording, &Entry::recording);
  return found == entries_.end() ? nullptr : &*found;
}

void MeasurementFiles::recording_seen(const RecordingStatus& status, const std::filesystem::path& folder) {
  // The frames of a replay have other numbers in a recording of it.
  if (!played_.empty()) return;
  const auto path_of = [&folder](const std::string& file) {
    return folder / std::filesystem::path(file).filename();
  };
  // What an earlier start has recorded has frames with other numbers.
  const bool has_ended = status.finished != std::exchange(finished_, status.finished) &&
                         status.last_trouble.empty() && !status.last_was_cut_off;
  if (has_ended) ended(path_of(status.last_file), status);
  const bool is_recording = status.state == RecordingStatus::State::kRecording && !status.ring;
  const bool has_frames = is_recording && status.first_sequence != kNoSequence;
  if (has_frames) under_way(path_of(status.file), status);
  end_others(is_recording ? path_of(status.file) : std::filesystem::path());
}

void MeasurementFiles::under_way(const std::filesystem::path& recording, const RecordingStatus& status) {
  Entry* entry = find(recording);
  const bool is_new = entry == nullptr;
  if (is_new) entry = &add(recording, status.first_sequence, kNoSequence);
  entry->last_seen = status.last_sequence;
  if (is_new) update(*entry);
}

/// A recording that is not under way any more ends with the last frame that was seen, unless its end is
/// reported.
void MeasurementFiles::end_others(const std::filesystem::path& than) {
  for (Entry& each : entries_)
    if (each.last_number == kNoSequence && each.recording != than) each.last_number = each.last_seen;
}

void MeasurementFiles::ended(const std::filesystem::path& recording, const RecordingStatus& status) {
  Entry* entry = find(recording);
  if (entry == nullptr)
    entry = &add(recording, status.last_file_first_sequence, status.last_file_last_sequence);
  entry->first_number = status.last_file_first_sequence;
  entry->last_number = status.last_file_last_sequence;
  entry->bytes = bytes_of(recording);
  if (entry->signature != 0 && !entry->is_closed) entry->file->changed();  // with the recording's size
  update(*entry);
}

void MeasurementFiles::update(Entry& entry) {
  const bool follows = !entry.is_closed && (may_write_ || entry.recording != played_);
  const std::uint64_t now = dependencies_.measurements.signature(entry.first_number, entry.last_number);
  if (follows && std::exchange(entry.signature, now) != now) entry.file->changed();
}

void MeasurementFiles::measurements_changed() {
  if (std::exchange(clearings_, dependencies_.measurements.clearings()) !=
      dependencies_.measurements.clearings()) {
    for (Entry& each : entries_) each.is_closed |= each.last_number != kNoSequence;
  }
  for (Entry& each : entries_) update(each);
}

void MeasurementFiles::finish() {
  for (Entry& each : entries_) each.file->finish();
}

std::string MeasurementFiles::trouble() const {
  const bool both = !read_trouble_.empty() && !write_trouble_.empty();
  return read_trouble_ + (both ? " " : "") + write_trouble_;
}

void MeasurementFiles::show_trouble() {
  std::string now = trouble();
  if (now == shown_trouble_) return;
  shown_trouble_ = std::move(now);
  dependencies_.measurements.keep_with_recording(shown_trouble_);
  if (dependencies_.trouble_changed) dependencies_.trouble_changed();
}

}  // namespace fanlight
