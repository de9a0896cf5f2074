// SPDX-License-Identifier: Apache-2.0
#pragma once

// DCMTK's first header must come first.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmnet/scu.h>

#include <functional>

namespace fanlight {

/// DCMTK's service class user, with the parts that it keeps for derived classes.
class DicomScu final : public DcmSCU {
 public:
  /// Takes each response to a query, in sendFINDRequest(); false: no more are wanted, and the association is
  /// aborted.
  std::function<bool(QRResponse&)> take_response;

  /// Encrypts the association; after initNetwork(). The layer must outlive this.
  OFCondition use_transport(DcmTransportLayer& layer) { return useSecureConnection(&layer); }

  OFCondition handleFINDResponse(T_ASC_PresentationContextID context, QRResponse* response,
                                 OFBool& wait_for_next) override {
    const OFCondition handled = DcmSCU::handleFINDResponse(context, response, wait_for_next);
    if (handled.good() && response != nullptr && take_response && !take_response(*response)) {
      wait_for_next = OFFalse;
      (void)abortAssociation();
    }
    return handled;
  }
};

}  // namespace fanlight
