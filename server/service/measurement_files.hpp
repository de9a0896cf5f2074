// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <optional>
#include <string>

#include "proto/exchange/recording_link.hpp"
#include "server/service/saved_file.hpp"
#include "server/state/measurement_store.hpp"

namespace fanlight {

/// Keeps measurements beside recordings, in FILE.measurements.json: those of the recording that is played,
/// and of a live source those on volumes that a recording of this start holds whole. Server thread only.
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

  /// Reads the measurements of the recording that is played. A file that cannot be read, or not whole, is
  /// copied aside before anything replaces it.
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
    std::uint64_t last_number;  // kNoSequence: it is being recorded
    std::uint64_t seen = 0;     // MeasurementStore::signature() at the last change
    std::optional<SavedFile> file{};
  };

  Entry& add(const std::filesystem::path& recording, std::uint64_t first, std::uint64_t last);
  Entry* find(const std::filesystem::path& recording);
  void begun(const std::filesystem::path& recording, std::uint64_t first);
  void ended(const std::filesystem::path& recording, std::uint64_t first, std::uint64_t last);
  void update(Entry& entry);
  void set_trouble(const std::string& trouble);

  std::filesystem::path played_;
  Dependencies dependencies_;
  std::list<Entry> entries_;
  std::uint64_t finished_ = 0;  // RecordingStatus::finished
  std::string trouble_;
};

}  // namespace fanlight
