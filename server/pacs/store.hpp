// SPDX-License-Identifier: Apache-2.0
#pragma once

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
    kStored,   ///< the peer has it
    kRefused,  ///< the peer will not take this object; sending it again does not help
    kNotSent,  ///< the peer had no room, or the connection broke; it may be sent again
  };
  State state = State::kNotSent;
  /// One sentence: why not, or the peer's warning about what it has stored. Empty where there is none.
  std::string sentence;
};

/// Sends DICOM files to an archive (C-STORE, PS3.4 B), in one association and in their order. The pixels go
/// as they are in the file; uncompressed ones in either byte layout of VRs (explicit or implicit). Returns an
/// outcome for each file; one that is not DICOM is refused. Errors, kUnavailable and kInvalidArgument: as of
/// Association::open().
Result<std::vector<StoreOutcome>> store_files(const DicomPeer& peer,
                                              std::span<const std::filesystem::path> files);

/// Asks for a sign of life (C-ECHO, PS3.4 A). Errors as of Association::open().
Result<void> check_echo(const DicomPeer& peer);

}  // namespace fanlight
