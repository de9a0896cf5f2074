// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"
#include "server/pacs/store.hpp"

namespace fanlight {

/// DICOM files on a disk that wait for one archive, in the order in which they came. They outlast the
/// program, a power cut, and an archive that is absent. The names of the files are times and random digits;
/// the files are their owner's alone. What the archive refuses for good is moved to the folder `refused` in
/// it; the file `archive` says for which archive the folder is. Several programs may add; one sends. One
/// thread.
class Outbox {
 public:
  struct Report {
    std::uint64_t stored = 0;
    std::uint64_t refused = 0;
    bool reached = false;  ///< the archive answered
    /// The last sentence about what was refused, was stored with a warning, or waits; empty where all is
    /// well.
    std::string sentence;
  };

  /// Makes the folder where it does not exist. kUnavailable. kInvalidArgument: it is for another archive, or
  /// people other than its owner and group may enter.
  static Result<Outbox> open(const std::filesystem::path& folder, const DicomPeer& peer);

  Outbox(Outbox&& other) noexcept
      : folder_(std::move(other.folder_)),
        peer_(std::move(other.peer_)),
        deferred_(std::move(other.deferred_)),
        lock_(std::exchange(other.lock_, -1)) {}
  Outbox& operator=(Outbox&&) = delete;
  ~Outbox();

  /// Puts an object in, synced to the disk; returns its file. kUnavailable.
  Result<std::filesystem::path> add(std::span<const std::uint8_t> object);
  /// Copies a DICOM file in; returns the copy. kUnavailable.
  Result<std::filesystem::path> add_file(const std::filesystem::path& path);
  /// Removes what was added, as far as it still waits.
  void take_back(std::span<const std::filesystem::path> added);

  /// How many objects wait.
  std::uint64_t waiting() const { return names().size(); }
  /// Whether some of them were never tried by this.
  bool has_untried() const;

  /// Whether this program is the one that sends: false while another does. kUnavailable: the folder is on a
  /// file system without locks.
  Result<bool> become_sender();

  /// Tries each object that waits once, also what comes meanwhile; what was never tried comes first. Ends
  /// sooner after kMostFailures in a row, and between objects when `stop` is set. For the sender. The error
  /// is for the first attempt to connect, as of store_files().
  Result<Report> send(const std::atomic<bool>& stop);

  static constexpr int kMostFailures = 3;

 private:
  Outbox(std::filesystem::path folder, DicomPeer peer) : folder_(std::move(folder)), peer_(std::move(peer)) {}

  Result<std::filesystem::path> add_by(const std::function<int(int)>& write);
  std::vector<std::filesystem::path> names() const;
  std::vector<std::filesystem::path> next_files(const std::set<std::filesystem::path>& tried) const;
  /// Counts an outcome, and does to the file what follows from it. Whether the object is done with.
  bool settle(const std::filesystem::path& path, const StoreOutcome& outcome, Report& report);
  Result<void> refuse(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  DicomPeer peer_;
  std::set<std::filesystem::path> deferred_;  ///< tried before, and not sent
  int lock_ = -1;                             ///< descriptor of the file with the lock of the sender
};

}  // namespace fanlight
