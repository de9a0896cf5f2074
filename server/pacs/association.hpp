// SPDX-License-Identifier: Apache-2.0
#pragma once

// DCMTK's first header must come first.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmtls/tlslayer.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"
#include "server/pacs/dicom_scu.hpp"

namespace fanlight {

/// What the association is for: a SOP class, and the transfer syntaxes that can be sent.
using DicomContext = std::pair<std::string, std::vector<std::string>>;

/// An open association with a peer, by DCMTK; it is released when it is destroyed. With TLS, of version 1.2
/// or later (the Non-Downgrading BCP 195 profile of PS3.15, B.10). One thread. Each call to `scu()` may wait
/// for as long as the peer may be silent: 10 s to connect, 60 s to agree, and as given to answer a request.
class Association {
 public:
  /// kUnavailable: the peer cannot be reached, its certificate is not accepted, or it refuses this program's
  /// title or its own. kUnsupported: it accepts none of the contexts. kInvalidArgument: a file for TLS.
  static Result<Association> open(const DicomPeer& peer, const std::vector<DicomContext>& contexts,
                                  int answer_seconds);

  Association(Association&&) noexcept = default;
  Association& operator=(Association&&) = delete;
  ~Association();

  DicomScu& scu() { return *scu_; }

 private:
  Association() : scu_(std::make_unique<DicomScu>()) {}

  std::unique_ptr<DcmTLSTransportLayer> tls_;  // outlives what uses it
  std::unique_ptr<DicomScu> scu_;
};

}  // namespace fanlight
