// SPDX-License-Identifier: Apache-2.0
#include "server/service/measurement_files.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

#include "proto/model/measurement_file.hpp"
#include "server/state/path_privacy.hpp"

namespace fanlight {

namespace {

constexpr std::uintmax_t kMostFileBytes = 20'000'000;

/// nullopt: there is no such file. Errors: kUnavailable, it cannot be read.
Result<std::optional<std::string>> read_file(const std::filesystem::path& path) {
  std::error_code failure;
  if (!std::filesystem::exists(path, failure) && !failure) return std::optional<std::string>();
  const Error unreadable{ErrorCode::kUnavailable, "it cannot be read, expected a file of at most 20 MB"};
  if (failure || std::filesystem::file_size(path, failure) > kMostFileBytes || failure) return unreadable;
  std::ifstream in(path, std::ios::binary);
  if (!in) return unreadable;
  return std::optional(std::string(std::istreambuf_iterator<char>(in), {}));
}

}  // namespace

MeasurementFiles::MeasurementFiles(std::filesystem::path played, Dependencies dependencies)
    : played_(std::move(played)), dependencies_(std::move(dependencies)) {}

void MeasurementFiles::load() {
  if (played_.empty()) return;
  const std::filesystem::path path = measurements_path_of(played_);
  const auto text = read_file(path);
  std::vector<std::string> troubles;
  if (!text) {
    troubles.push_back(text.error().message);
  } else if (*text) {
    troubles = dependencies_.measurements.load(**text);
  }
  Entry& entry = add(played_, 0, kNoSequence);
  entry.seen = dependencies_.measurements.signature(entry.first_number, entry.last_number);
  if (troubles.empty()) return set_trouble("");
  const std::string aside = copied_aside(path);
  for (const std::string& trouble : troubles)
    spdlog::warn("{}: {}{}", path.string(), trouble, aside.empty() ? "" : "; the file as it was is " + aside);
  set_trouble("Not all measurements of this recording could be read: " + troubles.front());
}

MeasurementFiles::Entry& MeasurementFiles::add(const std::filesystem::path& recording, std::uint64_t first,
                                               std::uint64_t last) {
  if (entries_.size() >= kMostRecordings && !entries_.front().file->is_writing()) entries_.pop_front();
  Entry& entry = entries_.emplace_back(recording, first, last);
  const bool is_played = recording == played_;
  const auto text = [this, &entry] {
    return dependencies_.measurements.file_text(entry.first_number, entry.last_number);
  };
  const auto written = [this, is_played](const Result<void>& saved) {
    if (!is_played) return;
    set_trouble(
        saved ? ""
              : "The measurements are kept until the server stops, since the recording's folder "
                "cannot be written: " +
                    without_path(saved.error().message, measurements_path_of(played_).string(), "the file"));
  };
  entry.file.emplace(
      measurements_path_of(recording),
      SavedFile::Content{.name = "the measurements", .text = text, .mode = 0600, .written = written},
      dependencies_.executor);
  return entry;
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
  if (has_ended)
    ended(path_of(status.last_file), status.last_file_first_sequence, status.last_file_last_sequence);
  const bool is_recording = status.state == RecordingStatus::State::kRecording && !status.ring;
  if (is_recording && status.first_sequence != kNoSequence)
    begun(path_of(status.file), status.first_sequence);
}

void MeasurementFiles::begun(const std::filesystem::path& recording, std::uint64_t first) {
  if (find(recording) != nullptr) return;
  // One whose end was not seen ends here at the latest.
  for (Entry& each : entries_)
    if (each.last_number == kNoSequence) each.last_number = first - 1;
  update(add(recording, first, kNoSequence));
}

void MeasurementFiles::ended(const std::filesystem::path& recording, std::uint64_t first,
                             std::uint64_t last) {
  Entry* entry = find(recording);
  if (entry == nullptr) entry = &add(recording, first, last);
  entry->first_number = first;
  entry->last_number = last;
  update(*entry);
}

void MeasurementFiles::update(Entry& entry) {
  const std::uint64_t now = dependencies_.measurements.signature(entry.first_number, entry.last_number);
  if (std::exchange(entry.seen, now) != now) entry.file->changed();
}

void MeasurementFiles::measurements_changed() {
  for (Entry& each : entries_) update(each);
}

void MeasurementFiles::finish() {
  for (Entry& each : entries_) each.file->finish();
}

void MeasurementFiles::set_trouble(const std::string& trouble) {
  dependencies_.measurements.keep_with_recording(trouble);
  if (std::exchange(trouble_, trouble) != trouble && dependencies_.trouble_changed)
    dependencies_.trouble_changed();
}

}  // namespace fanlight
