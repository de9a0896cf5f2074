// SPDX-License-Identifier: Apache-2.0
#include "server/cli/pacs_options.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <utility>

#include "proto/base/printable.hpp"

namespace fanlight {

void PacsOptions::add_to(CLI::App& command) {
  command.add_option("--own-title", own_title, "Title of this program, which the archive must know")
      ->capture_default_str()
      ->type_name("TITLE");
  command
      .add_option(
          "--tls-ca", ca_file,
          "PEM file with who may sign the peer's certificate. It turns on TLS for TITLE@HOST:PORT, where "
          "names in certificates are not compared: list only who signs for your archive. With a URL, "
          "in place of the system's authorities")
      ->type_name("FILE");
  auto* const certificate = command
                                .add_option("--tls-cert", certificate_file,
                                            "Certificate of this program, PEM, for an archive that wants one")
                                ->type_name("FILE");
  auto* const key =
      command.add_option("--tls-key", key_file, "Private key of the certificate, PEM")->type_name("FILE");
  certificate->needs(key);
  key->needs(certificate);
}

Result<DicomPeer> PacsOptions::dicom_peer() const {
  auto parsed = parse_dicom_peer(peer);
  if (!parsed) return parsed.error();
  if (auto title = check_dicom_title(own_title); !title) return title.error();
  if (ca_file.empty() && !certificate_file.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--tls-cert without --tls-ca, expected both for an archive by TITLE@HOST:PORT"};
  }
  parsed->own_title = own_title;
  parsed->tls = !ca_file.empty();
  parsed->ca_file = ca_file;
  parsed->certificate_file = certificate_file;
  parsed->key_file = key_file;
  return parsed;
}

Result<Archive> PacsOptions::archive() const {
  for (const std::string* path : {&ca_file, &certificate_file, &key_file}) {
    if (path->empty() || access(path->c_str(), R_OK) == 0) continue;
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} cannot be read, expected a PEM file", printable(*path))};
  }
  if (!is_url(peer)) {
    if (!http_login.empty()) {
      return Error{ErrorCode::kInvalidArgument,
                   "--http-login is for an archive with a URL, expected --to https://..."};
    }
    const auto parsed = dicom_peer();
    return parsed ? archive_of(*parsed) : Result<Archive>(parsed.error());
  }
  std::string login;
  if (!http_login.empty()) {
    auto read = read_http_login(http_login);
    if (!read) return read.error();
    login = std::move(*read);
  }
  auto parsed = parse_dicom_web(peer, std::move(login));
  if (!parsed) return parsed.error();
  parsed->ca_file = ca_file;
  parsed->certificate_file = certificate_file;
  parsed->key_file = key_file;
  return archive_of(*parsed);
}

}  // namespace fanlight
