// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/archive.hpp"

namespace fanlight {

/// DICOM files on a disk that wait for one archive, in the order in which they came. They outlast the
/// program, a power cut, and an archive that is absent. The names of the files are times and random digits;
/// the files are their owner's alone. What failed has a name that begins with `tried-`, and comes last. What
/// the archive refuses for good is moved to the folder `refused` in it; the file `archive` says for which
/// archive the folder is. Several programs may add; one sends. One thread.
class Outbox {
 public:
  struct Report {
    std::uint64_t stored = 0;
    std::uint64_t refused = 0;
    bool reached = false;  ///< the archive has answered for an object
    /// The last sentence about what was refused, was stored with a warning, or waits; empty where all is
    /// well.
    std::string sentence;
  };

  enum class Which : bool { kAll, kUntried };

  /// Makes the folder where it does not exist. kUnavailable. kInvalidArgument: it is for another archive, or
  /// people other than its owner and group may enter.
  static Result<Outbox> open(const std::filesystem::path& folder, Archive archive);

  /// The same for a program that adds and never sends, for whatever archive.
  static Result<Outbox> open_to_add(const std::filesystem::path& folder);

  Outbox(Outbox&& other) noexcept
      : folder_(std::move(other.folder_)),
        archive_(std::move(other.archive_)),
        deferred_(std::move(other.deferred_)),
        stored_(std::move(other.stored_)),
        labels_(std::move(other.labels_)),
        lock_(std::exchange(other.lock_, -1)) {}
  Outbox& operator=(Outbox&&) = delete;
  ~Outbox();

  /// Writes an object, synced to the disk, under a name that no sender looks at; returns its file.
  /// `label`: what messages of this program call it; empty: the name of its file. kUnavailable.
  Result<std::filesystem::path> stage(std::span<const std::uint8_t> object, std::string label);
  /// The same with the copy of a DICOM file.
  Result<std::filesystem::path> stage_file(const std::filesystem::path& path);
  /// What was staged waits from now on. kUnavailable.
  Result<void> publish(std::span<const std::filesystem::path> staged);
  /// Removes what was staged and not published.
  static void discard(std::span<const std::filesystem::path> staged);

  bool can_be_written() const;
  /// How many objects wait, and how many were refused.
  std::uint64_t waiting() const;
  std::uint64_t refused() const;
  /// Whether some of them were never tried by this.
  bool has_untried() const;

  /// Whether this program is the one that sends: false while another does. kUnavailable: the folder is on a
  /// file system without locks.
  Result<bool> become_sender();

  /// Tries each object that waits once, or those alone that this never tried; also what comes meanwhile. Ends
  /// sooner after kMostFailuresInARow of the archive, and between objects when `stop` is set. For the sender.
  /// Errors: as of Archive::store, while nothing was stored or refused; kUnavailable, the folder cannot be
  /// read; kInvalidArgument, it is for another archive now.
  Result<Report> send(Which which, const std::atomic<bool>& stop);

 private:
  using Paths = std::vector<std::filesystem::path>;

  Outbox(std::filesystem::path folder, Archive archive)
      : folder_(std::move(folder)), archive_(std::move(archive)) {}

  Result<std::filesystem::path> stage_by(std::string label, const std::function<int(int)>& write);
  std::string label_of(const std::filesystem::path& path) const;
  Result<Paths> waiting_files() const;
  Result<Paths> next_files(Which which, const std::set<std::filesystem::path>& tried) const;
  std::filesystem::path settle(const std::filesystem::path& path, const StoreOutcome& outcome,
                               Report& report);
  std::filesystem::path defer(const std::filesystem::path& path);
  void remove_stored(const std::filesystem::path& path, std::string& sentence);
  Result<void> refuse(const std::filesystem::path& path) const;
  void remove_stale() const;

  std::filesystem::path folder_;
  Archive archive_;
  std::set<std::filesystem::path> deferred_;   ///< tried by this, and not sent
  std::set<std::filesystem::path> stored_;     ///< the archive has them, and they could not be removed
  std::map<std::string, std::string> labels_;  ///< by the names of files
  int lock_ = -1;                              ///< descriptor of the file with the lock of the sender
};

}  // namespace fanlight
