// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"
#include "server/pacs/dicom_web.hpp"
#include "server/pacs/store_outcome.hpp"

namespace fanlight {

/// Where objects are stored, whatever the protocol.
struct Archive {
  std::string name;  ///< TITLE@HOST:PORT or a URL, for messages
  /// Sends files in their order, and returns an outcome for each. Looks at `stop` between objects, or sooner.
  /// Errors: kUnavailable, it cannot be reached; kInvalidArgument, such as a file for TLS.
  std::function<Result<std::vector<StoreOutcome>>(std::span<const std::filesystem::path> files,
                                                  const std::atomic<bool>& stop)>
      store;
  std::function<Result<void>()> check;  ///< asks for a sign of life; errors as of `store`
};

/// By C-STORE and C-ECHO.
Archive archive_of(const DicomPeer& peer);

/// By STOW-RS and QIDO-RS.
Archive archive_of(const DicomWebPeer& peer);

}  // namespace fanlight
