// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/exchange/recording_link.hpp"
#include "server/service/saved_file.hpp"
#include "server/state/measurement_store.hpp"

namespace fanlight {

/// Keeps measurements beside recordings, in FILE.measurements.json: those of the recording that is played,
/// and of a live source those on volumes that a recording of this start holds whole. Where all measurements
/// are removed, files of recordings that have ended keep theirs. A file that another program has changed is
/// left alone. Server thread only.
class MeasurementFiles {
 public:
  struct Dependencies {
    MeasurementStore& measurements;
    Executor executor;
    std::function<void()> trouble_changed;  ///< of the store's list: sessions are to be notified
  };
  /// `played`: the recording that is played; empty: none. The dependencies must outlive this object, and no
  /// work may run after its end.
  MeasurementFiles(std::filesystem::path played, Dependencies dependencies);

  /// Reads the measurements of the recording that is played, before there are sessions; any thread. A file
  /// that cannot be read, or not whole, gets a further name first; where that fails, nothing is written.
  void load();

  /// The recorder has reported. `folder`: of the recordings.
  void recording_seen(const RecordingStatus& status, const std::filesystem::path& folder);

  /// The measurements have changed: writes the files that this concerns soon.
  void measurements_changed();

  /// Writes at once what is not written yet: the server ends.
  void finish();

 private:
  static constexpr std::size_t kMostRecordings = 200;

  /// A file, and the numbers of the frames of its recording.
  struct Entry {
    Entry(std::filesystem::path of, std::uint64_t first, std::uint64_t last)
        : recording(std::move(of)), first_number(first), last_number(last) {}

    std::filesystem::path recording;
    std::uint64_t first_number;
    std::uint64_t last_number;    // kNoSequence: it is being recorded, or played
    std::uint64_t last_seen = 0;  // while it is being recorded
    std::uint64_t bytes = 0;      // MeasurementFile.recording_bytes
    std::uint64_t signature = 0;  // of the store at the last change
    bool is_closed = false;       // follows the store no longer
    std::optional<SavedFile> file{};
  };

  Entry& add(const std::filesystem::path& recording, std::uint64_t first, std::uint64_t last);
  Entry* find(const std::filesystem::path& recording);
  void under_way(const std::filesystem::path& recording, const RecordingStatus& status);
  void end_others(const std::filesystem::path& than);
  void ended(const std::filesystem::path& recording, const RecordingStatus& status);
  void update(Entry& entry);
  void written(const Result<void>& saved);
  void set_aside(const std::filesystem::path& path, const std::vector<std::string>& troubles);
  std::string trouble() const;
  void show_trouble();

  std::filesystem::path played_;
  Dependencies dependencies_;
  std::list<Entry> entries_;
  std::uint64_t finished_ = 0;   // RecordingStatus::finished
  std::uint64_t clearings_ = 0;  // of the store, that are followed
  bool may_write_ = true;        // the file of the recording that is played
  // Sentences for people; empty: no trouble.
  std::string read_trouble_;
  std::string write_trouble_;
  std::string shown_trouble_;
};

}  // namespace fanlight
