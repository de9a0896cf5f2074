// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <span>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"
#include "server/pacs/store_outcome.hpp"

namespace fanlight {

/// Sends DICOM files to an archive (C-STORE, PS3.4 B), in one association and in their order. The pixels go
/// as they are in the file; uncompressed ones in either byte layout of VRs (explicit or implicit). Returns an
/// outcome for each file; one that is not DICOM, or has no identifier, is refused. Any failure of the
/// connection ends it: an answer that comes late could be taken for that to the next object. Three failures
/// of the peer's in a row end it too. `stop` is looked at between objects. Errors, kUnavailable and
/// kInvalidArgument: as of Association::open().
Result<std::vector<StoreOutcome>> store_files(const DicomPeer& peer,
                                              std::span<const std::filesystem::path> files,
                                              const std::atomic<bool>& stop);

/// Asks for a sign of life (C-ECHO, PS3.4 A). Errors as of Association::open().
Result<void> check_echo(const DicomPeer& peer);

}  // namespace fanlight
