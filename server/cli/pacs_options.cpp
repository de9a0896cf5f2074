// SPDX-License-Identifier: Apache-2.0
#include "server/cli/pacs_options.hpp"

#include <CLI/CLI.hpp>

namespace fanlight {

void PacsOptions::add_to(CLI::App& command) {
  command.add_option("--own-title", own_title, "Title of this program, which the archive must know")
      ->capture_default_str()
      ->type_name("TITLE");
  command
      .add_option("--tls-ca", ca_file,
                  "Use TLS, and accept a certificate that is signed by one of this PEM file. Names in "
                  "certificates are not compared: list only who signs for your archive")
      ->type_name("FILE");
  auto* const certificate = command
                                .add_option("--tls-cert", certificate_file,
                                            "Certificate of this program, PEM, for an archive that wants one")
                                ->type_name("FILE");
  auto* const key =
      command.add_option("--tls-key", key_file, "Private key of the certificate, PEM")->type_name("FILE");
  certificate->needs(key)->needs("--tls-ca");
  key->needs(certificate);
}

Result<DicomPeer> PacsOptions::dicom_peer() const {
  auto parsed = parse_dicom_peer(peer);
  if (!parsed) return parsed.error();
  if (auto title = check_dicom_title(own_title); !title) return title.error();
  parsed->own_title = own_title;
  parsed->tls = !ca_file.empty();
  parsed->ca_file = ca_file;
  parsed->certificate_file = certificate_file;
  parsed->key_file = key_file;
  return parsed;
}

}  // namespace fanlight
