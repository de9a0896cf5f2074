// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"

namespace fanlight {

/// DICOM files on a disk that wait for an archive, in the order in which they came. They outlast the program,
/// a power cut, and an archive that is absent. The names of the files are times and random digits; the folder
/// is its owner's alone. What the archive refuses for good is moved to the folder `refused` in it.
/// Several programs may add; one sends. One thread.
class Outbox {
 public:
  struct Report {
    std::uint64_t stored = 0;
    std::uint64_t refused = 0;
    /// The last sentence about what was refused, was stored with a warning, or waits; empty where all is
    /// well.
    std::string sentence;
  };

  /// Makes the folder where it does not exist. kUnavailable.
  static Result<Outbox> open(const std::filesystem::path& folder);

  Outbox(Outbox&& other) noexcept
      : folder_(std::move(other.folder_)), lock_(std::exchange(other.lock_, -1)) {}
  Outbox& operator=(Outbox&&) = delete;
  ~Outbox();

  /// Puts an object in, synced to the disk. kUnavailable.
  Result<void> add(std::span<const std::uint8_t> object);
  /// Copies a DICOM file in. kBadInput: it is none. kUnavailable.
  Result<void> add_file(const std::filesystem::path& path);

  /// How many objects wait.
  std::uint64_t waiting() const { return names().size(); }

  /// Whether this program is the one that sends: false while another does. kUnavailable.
  Result<bool> become_sender();

  /// Sends what waits, until the archive cannot take more; that stays. For the sender. The error is for the
  /// first attempt to connect, as of store_files(), or kUnavailable for the folder.
  Result<Report> send(const DicomPeer& peer);

 private:
  explicit Outbox(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::vector<std::filesystem::path> names() const;
  Result<void> refuse(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  int lock_ = -1;  ///< descriptor of the folder; it has the lock of the sender
};

}  // namespace fanlight
