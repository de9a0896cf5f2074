// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/store_outcome.hpp"

namespace fanlight {

/// A DICOMweb service (PS3.18), and how it is reached.
struct DicomWebPeer {
  std::string url;      ///< of the service, such as https://pacs.example/dicom-web; no slash at its end
  std::string ca_file;  ///< PEM; empty: the system's authorities
  std::string certificate_file;  ///< PEM; of this program, where the service wants one
  std::string key_file;          ///< PEM
  std::string login;             ///< USER:PASSWORD (Basic) or "Bearer TOKEN"; empty: none. It is secret
};

/// Whether a text is a URL, and no TITLE@HOST:PORT.
bool is_url(std::string_view text);

/// kInvalidArgument: no URL of http or https; one with a login in it; or a login that would cross a network
/// unencrypted.
Result<DicomWebPeer> parse_dicom_web(const std::string& url, std::string login = "");

/// Reads USER:PASSWORD or "Bearer TOKEN" from the first line of a file. kInvalidArgument; the sentence does
/// not repeat what it has read.
Result<std::string> read_http_login(const std::filesystem::path& path);

/// The URL, for messages.
std::string shown(const DicomWebPeer& peer);

/// Sends DICOM files, each in a request of its own (STOW-RS, PS3.18, 10.5), by libcurl: the file is read as
/// it is sent. TLS is of version 1.2 or later, and the certificate must name the host. A proxy is that of the
/// environment. Waits up to 10 s for a connection and 10 minutes for an answer; `stop` ends it sooner.
/// Errors, for the first file only: kUnavailable, the service cannot be reached, is none, or refuses the
/// login; kInvalidArgument, a file for TLS. A connection that breaks later is a failure of that object.
Result<std::vector<StoreOutcome>> store_by_web(const DicomWebPeer& peer,
                                               std::span<const std::filesystem::path> files,
                                               const std::atomic<bool>& stop);

/// Asks for one study (QIDO-RS, PS3.18, 10.6). Errors as of store_by_web().
Result<void> check_web(const DicomWebPeer& peer);

/// What an answer to a stored object means: its status and its body (PS3.18, table 10.5.3-1, and its JSON).
/// 0: the connection broke, and the body is the reason. kUnavailable: the service is none, or refuses the
/// login; other objects would fare alike.
Result<StoreOutcome> outcome_of_answer(long status, const std::string& body);

}  // namespace fanlight
