// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/association.hpp"

#include <dcmtk/dcmnet/cond.h>
#include <dcmtk/dcmnet/dcmtrans.h>
#include <fmt/format.h>

#include "proto/base/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

namespace {

constexpr int kConnectSeconds = 10;
constexpr int kAgreeSeconds = 60;

/// A part of TLS that is not as it should be.
Error not_prepared(const std::string& path, const OFCondition& problem, std::string_view expected) {
  return {ErrorCode::kInvalidArgument, fmt::format("{} cannot be used for TLS ({}), expected {}",
                                                   printable(path), printable(problem.text()), expected)};
}

constexpr auto kProfile = TSP_Profile_BCP195_ND;

/// DCMTK 3.6.8 and later want the profile too.
OFCondition set_certificate(auto& layer, const char* file) {
  if constexpr (requires { layer.setCertificateFile(file, DCF_Filetype_PEM); }) {
    return layer.setCertificateFile(file, DCF_Filetype_PEM);
  } else {
    return layer.setCertificateFile(file, DCF_Filetype_PEM, kProfile);
  }
}

/// Everything that makes a connection safe is checked here: DCMTK's own class for it passes over a file that
/// it cannot read, and never puts the profile in force.
Result<std::unique_ptr<DcmTLSTransportLayer>> tls_of(const DicomPeer& peer) {
  auto layer = std::make_unique<DcmTLSTransportLayer>(NET_REQUESTOR, nullptr, OFTrue);
  if (const OFCondition set = layer->setTLSProfile(kProfile); set.bad())
    return not_prepared("DICOM's TLS profile", set, "OpenSSL with its cipher suites");
  if (const OFCondition set = layer->activateCipherSuites(); set.bad())
    return not_prepared("DICOM's TLS profile", set, "OpenSSL with its cipher suites");
  if (const auto added = layer->addTrustedCertificateFile(peer.ca_file.c_str(), DCF_Filetype_PEM);
      added.bad())
    return not_prepared(peer.ca_file, added, "a PEM file with certificates");
  layer->setCertificateVerification(DCV_requireCertificate);
  if (peer.certificate_file.empty()) return layer;
  if (const auto set = layer->setPrivateKeyFile(peer.key_file.c_str(), DCF_Filetype_PEM); set.bad())
    return not_prepared(peer.key_file, set, "a PEM file with a private key");
  if (const auto set = set_certificate(*layer, peer.certificate_file.c_str()); set.bad())
    return not_prepared(peer.certificate_file, set, "a PEM file with a certificate");
  if (!layer->checkPrivateKeyMatchesCertificate()) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} is not the key of {}, expected a certificate and its private key",
                             printable(peer.key_file), printable(peer.certificate_file))};
  }
  return layer;
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
  if (problem.module() == OFM_dcmtls || problem.code() == DULC_TLSERROR) {
    return unavailable(fmt::format(
        "no TLS connection ({}), expected TLS 1.2 or later and a certificate that is signed by one of {}",
        text, printable(peer.ca_file)));
  }
  return unavailable(fmt::format("no association ({}), expected a DICOM peer that is running", text));
}

}  // namespace

Result<Association> Association::open(const DicomPeer& peer, const std::vector<DicomContext>& contexts,
                                      int answer_seconds) {
  silence_dicom_log();
  Association association;
  if (peer.tls) {
    auto layer = tls_of(peer);
    if (!layer) return layer.error();
    association.tls_ = std::move(*layer);
  }
  dcmSocketSendTimeout.set(answer_seconds);  // of every association of this program
  DicomScu& scu = association.scu();
  scu.setAETitle(peer.own_title.c_str());
  scu.setPeerAETitle(peer.called_title.c_str());
  scu.setPeerHostName(peer.host.c_str());
  scu.setPeerPort(peer.port);
  scu.setConnectionTimeout(kConnectSeconds);
  scu.setACSETimeout(kAgreeSeconds);
  scu.setDIMSETimeout(static_cast<Uint32>(answer_seconds));
  scu.setDIMSEBlockingMode(DIMSE_NONBLOCKING);
  scu.setDatasetConversionMode(OFTrue);  // between the uncompressed transfer syntaxes
  for (const auto& [sop_class, syntaxes] : contexts) {
    OFList<OFString> list;
    for (const std::string& syntax : syntaxes) list.push_back(syntax.c_str());
    if (const OFCondition added = scu.addPresentationContext(sop_class.c_str(), list); added.bad())
      return not_open(peer, added);
  }
  if (const OFCondition ready = scu.initNetwork(); ready.bad()) return not_open(peer, ready);
  if (association.tls_) {
    if (const OFCondition used = scu.use_transport(*association.tls_); used.bad())
      return not_open(peer, used);
  }
  if (const OFCondition agreed = scu.negotiateAssociation(); agreed.bad()) return not_open(peer, agreed);
  return association;
}

Association::~Association() {
  if (scu_ && scu_->isConnected()) (void)scu_->releaseAssociation();
}

}  // namespace fanlight
