// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"

namespace fanlight {

/// What became of a file that was to be stored.
struct StoreOutcome {
  enum class State : std::uint8_t {
    kStored,    ///< the peer has it
    kRefused,   ///< the peer will not take this object; sending it again does not help
    kNotSent,   ///< it could not be read, the peer had no room, or the connection broke; it may be sent again
    kNotTried,  ///< the connection had broken before, or `stop` was set
  };
  State state = State::kNotTried;
  /// One sentence: why not, or the peer's warning about what it has stored. Empty where there is none.
  std::string sentence;
};

/// Sends DICOM files to an archive (C-STORE, PS3.4 B), in one association and in their order. The pixels go
/// as they are in the file; uncompressed ones in either byte layout of VRs (explicit or implicit). Returns an
/// outcome for each file; one that is not DICOM, or has no identifier, is refused. Any failure of the
/// connection ends it: an answer that comes late could be taken for that to the next object. `stop` is looked
/// at between objects. Errors, kUnavailable and kInvalidArgument: as of Association::open().
Result<std::vector<StoreOutcome>> store_files(const DicomPeer& peer,
                                              std::span<const std::filesystem::path> files,
                                              const std::atomic<bool>& stop);

/// Asks for a sign of life (C-ECHO, PS3.4 A). Errors as of Association::open().
Result<void> check_echo(const DicomPeer& peer);

/// What a status in the answer to a C-STORE means (PS3.4, table B.2-1, and PS3.7, annex C).
StoreOutcome outcome_of_status(std::uint16_t status);

}  // namespace fanlight
