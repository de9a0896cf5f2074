// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/association.hpp"

#include <dcmtk/dcmnet/cond.h>
#include <dcmtk/dcmtls/tlsscu.h>
#include <fmt/format.h>

#include <unistd.h>

#include "proto/base/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

namespace {

constexpr int kConnectSeconds = 10;
constexpr int kAnswerSeconds = 60;

Result<void> check_readable(const std::string& path, std::string_view what) {
  if (path.empty() || access(path.c_str(), R_OK) == 0) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} cannot be read, expected {}", printable(path), what)};
}

Result<std::unique_ptr<DcmSCU>> scu_of(const DicomPeer& peer) {
  if (!peer.tls) return std::make_unique<DcmSCU>();
  for (const auto& [path, what] : {std::pair{peer.ca_file, "a PEM file with certificates"},
                                   std::pair{peer.certificate_file, "a PEM file with a certificate"},
                                   std::pair{peer.key_file, "a PEM file with a private key"}}) {
    if (auto found = check_readable(path, what); !found) return found.error();
  }
  auto scu = std::make_unique<DcmTLSSCU>();
  scu->addTrustedCertFile(peer.ca_file.c_str());
  scu->setPeerCertVerification(DCV_requireCertificate);
  if (!peer.certificate_file.empty())
    scu->enableAuthentication(peer.key_file.c_str(), peer.certificate_file.c_str(), "");
  return std::unique_ptr<DcmSCU>(std::move(scu));
}

Error not_open(const DicomPeer& peer, const OFCondition& problem) {
  const auto unavailable = [&](std::string_view sentence) {
    return Error{ErrorCode::kUnavailable, fmt::format("{}: {}", shown(peer), sentence)};
  };
  if (problem == NET_EC_NoAcceptablePresentationContexts) {
    return {ErrorCode::kUnsupported,
            fmt::format("{}: it accepts none of these objects, expected a peer for them", shown(peer))};
  }
  const std::string text = printable(problem.text());
  // DCMTK keeps the reason to itself; nearly always it is one of the two titles.
  if (problem.code() == DULC_ASSOCIATIONREJECTED) {
    return unavailable(
        fmt::format("it rejects the association, expected its own title ({}) and one that it knows ({})",
                    printable(peer.called_title), printable(peer.own_title)));
  }
  if (problem.code() == DULC_TLSERROR) {
    return unavailable(
        fmt::format("no TLS connection ({}), expected a certificate that is signed by one of {}", text,
                    printable(peer.ca_file)));
  }
  return unavailable(fmt::format("no association ({}), expected a DICOM peer that is running", text));
}

}  // namespace

Result<Association> Association::open(const DicomPeer& peer, const std::vector<DicomContext>& contexts) {
  silence_dicom_log();
  auto made = scu_of(peer);
  if (!made) return made.error();
  DcmSCU& scu = **made;
  scu.setAETitle(peer.own_title.c_str());
  scu.setPeerAETitle(peer.called_title.c_str());
  scu.setPeerHostName(peer.host.c_str());
  scu.setPeerPort(peer.port);
  scu.setConnectionTimeout(kConnectSeconds);
  scu.setACSETimeout(kAnswerSeconds);
  scu.setDIMSETimeout(kAnswerSeconds);
  scu.setDIMSEBlockingMode(DIMSE_NONBLOCKING);
  scu.setDatasetConversionMode(OFTrue);  // between the uncompressed transfer syntaxes
  for (const auto& [sop_class, syntaxes] : contexts) {
    OFList<OFString> list;
    for (const std::string& syntax : syntaxes) list.push_back(syntax.c_str());
    if (const OFCondition added = scu.addPresentationContext(sop_class.c_str(), list); added.bad())
      return not_open(peer, added);
  }
  if (const OFCondition ready = scu.initNetwork(); ready.bad()) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("TLS cannot be prepared ({}), expected a certificate and its private key, both PEM",
                    printable(ready.text()))};
  }
  // TLS 1.2 or later (DICOM's Non-Downgrading BCP 195 profile). It can be chosen only now.
  if (auto* const secure = dynamic_cast<DcmTLSSCU*>(&scu);
      secure != nullptr && secure->setTLSProfile(TSP_Profile_BCP195_ND).bad()) {
    return Error{ErrorCode::kUnavailable,
                 "TLS 1.2 cannot be chosen, expected OpenSSL with DICOM's cipher suites"};
  }
  if (const OFCondition agreed = scu.negotiateAssociation(); agreed.bad()) return not_open(peer, agreed);
  return Association(std::move(*made));
}

Association::~Association() {
  if (scu_ && scu_->isConnected()) (void)scu_->releaseAssociation();
}

}  // namespace fanlight
