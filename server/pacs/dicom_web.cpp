// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/dicom_web.hpp"

#include <curl/curl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/base/printable.hpp"
#include "server/pacs/dicom_file.hpp"

namespace fanlight {

namespace {

constexpr long kHttpConnectSeconds = 10;
constexpr long kHttpAnswerSeconds = 600;
constexpr std::size_t kMostAnswerBytes = std::size_t{1} << 20;
constexpr const char* kUserAgent = "Fanlight";
constexpr std::string_view kBearer = "Bearer ";

struct HttpAnswer {
  long status = 0;   ///< 0: the connection broke after it was made
  std::string body;  ///< the reason, where it broke
};

/// Requests to one address by libcurl, over one connection where the service keeps it.
class Transfer {
 public:
  Transfer(const DicomWebPeer& peer, const std::string& path, const std::atomic<bool>& stop) {
    set(CURLOPT_URL, (peer.url + path).c_str());
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_SSLVERSION, long{CURL_SSLVERSION_TLSv1_2});
    set(CURLOPT_USERAGENT, kUserAgent);
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_CONNECTTIMEOUT, kHttpConnectSeconds);
    set(CURLOPT_LOW_SPEED_LIMIT, 1L);
    set(CURLOPT_LOW_SPEED_TIME, kHttpAnswerSeconds);
    set(CURLOPT_ERRORBUFFER, problem_.data());
    if (!peer.ca_file.empty()) {
      set(CURLOPT_CAINFO, peer.ca_file.c_str());
      set(CURLOPT_CAPATH, nullptr);
    }
    if (!peer.certificate_file.empty()) {
      set(CURLOPT_SSLCERT, peer.certificate_file.c_str());
      set(CURLOPT_SSLKEY, peer.key_file.c_str());
    }
    add_header("Accept: application/dicom+json");
    add_header("Expect: 100-continue");  // an archive that refuses the login says so, and then closes
    set_login(peer.login);
    set(CURLOPT_WRITEDATA, &answer_.body);
    set(
        CURLOPT_WRITEFUNCTION, +[](char* bytes, std::size_t, std::size_t size, std::string* body) {
          const std::size_t room = kMostAnswerBytes - std::min(body->size(), kMostAnswerBytes);
          body->append(bytes, std::min(size, room));
          return size;
        });
    set(CURLOPT_XFERINFODATA, &stop);
    set(
        CURLOPT_XFERINFOFUNCTION,
        +[](const std::atomic<bool>* asked, curl_off_t, curl_off_t, curl_off_t, curl_off_t) -> int {
          return *asked ? 1 : 0;
        });
    set(CURLOPT_NOPROGRESS, 0L);
  }
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;
  ~Transfer() {
    curl_mime_free(body_);
    curl_slist_free_all(headers_);
    curl_easy_cleanup(curl_);
  }

  /// GET.
  Result<HttpAnswer> ask() {
    set(CURLOPT_HTTPHEADER, headers_);
    return run();
  }

  /// POST of a file, as the only part of the body. May be called again, and keeps the connection.
  Result<HttpAnswer> send_file(const std::filesystem::path& path) {
    if (body_ == nullptr) add_header("Content-Type: multipart/related; type=\"application/dicom\"");
    set(CURLOPT_HTTPHEADER, headers_);
    curl_mime* const before = std::exchange(body_, curl_mime_init(curl_));
    curl_mimepart* part = curl_mime_addpart(body_);
    failed_ = failed_ || part == nullptr || curl_mime_filedata(part, path.c_str()) != CURLE_OK ||
              curl_mime_filename(part, nullptr) != CURLE_OK ||
              curl_mime_type(part, "application/dicom") != CURLE_OK;
    set(CURLOPT_MIMEPOST, body_);
    curl_mime_free(before);
    return run();
  }

 private:
  /// kUnavailable: there is no connection; kInvalidArgument: a file for TLS. The sentence has libcurl's
  /// reason.
  Result<HttpAnswer> run() {
    answer_ = {};
    problem_[0] = '\0';
    const CURLcode done = failed_ ? CURLE_OUT_OF_MEMORY : curl_easy_perform(curl_);
    if (done != CURLE_OK) {
      const bool is_argument = done == CURLE_SSL_CERTPROBLEM || done == CURLE_SSL_CACERT_BADFILE;
      const char* const text = problem_[0] != '\0' ? problem_.data() : curl_easy_strerror(done);
      curl_off_t connected_us = 0;
      (void)curl_easy_getinfo(curl_, CURLINFO_PRETRANSFER_TIME_T, &connected_us);
      if (connected_us > 0 && !is_argument) return HttpAnswer{.status = 0, .body = printable(text)};
      return Error{is_argument ? ErrorCode::kInvalidArgument : ErrorCode::kUnavailable, printable(text)};
    }
    curl_easy_getinfo(curl_, CURLINFO_RESPONSE_CODE, &answer_.status);
    return std::move(answer_);
  }
  template <typename Value>
  void set(CURLoption option, Value value) {
    failed_ = failed_ || curl_ == nullptr || curl_easy_setopt(curl_, option, value) != CURLE_OK;
  }
  void set_login(std::string_view login) {
    if (login.empty()) return;
    const bool is_token = login.starts_with(kBearer);
    if (is_token) login.remove_prefix(kBearer.size());
    set(CURLOPT_HTTPAUTH, is_token ? CURLAUTH_BEARER : CURLAUTH_BASIC);
    set(is_token ? CURLOPT_XOAUTH2_BEARER : CURLOPT_USERPWD, std::string(login).c_str());
  }
  void add_header(const std::string& header) {
    curl_slist* const longer = curl_slist_append(headers_, header.c_str());
    if (longer == nullptr) failed_ = true;
    if (longer != nullptr) headers_ = longer;
  }

  CURL* curl_ = curl_easy_init();
  curl_slist* headers_ = nullptr;
  curl_mime* body_ = nullptr;
  bool failed_ = false;
  std::array<char, CURL_ERROR_SIZE> problem_{};
  HttpAnswer answer_;
};

/// The reason of the first object that failed; 0: none did, or the body does not say so.
unsigned failure_reason(const std::string& body) {
  constexpr const char* kFailedSequence = "00081198";
  constexpr const char* kReason = "00081197";
  const auto json = nlohmann::json::parse(body, nullptr, false);
  const auto item = nlohmann::json::json_pointer(fmt::format("/{}/Value/0", kFailedSequence));
  if (!json.is_object() || !json.contains(item)) return 0;
  const auto reason = item / kReason / "Value" / 0;
  constexpr unsigned kProcessingFailure = 0x0110;  // where no reason is given
  return json.contains(reason) && json[reason].is_number_unsigned() ? json[reason].get<unsigned>()
                                                                    : kProcessingFailure;
}

bool is_local(std::string_view host) {
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

Error wrong_url(const std::string& url, std::string_view expected) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("\"{}\" cannot be used, expected {}", printable(url), expected)};
}

}  // namespace

bool is_url(std::string_view text) {
  return text.find("://") != std::string_view::npos;
}

Result<DicomWebPeer> parse_dicom_web(const std::string& url, std::string login) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parts(curl_url(), &curl_url_cleanup);
  const auto part = [&parts](CURLUPart which) {
    char* text = nullptr;
    const bool found = curl_url_get(parts.get(), which, &text, 0) == CURLUE_OK && text != nullptr;
    std::string value = found ? text : "";
    curl_free(text);
    return value;
  };
  const bool is_http = url.starts_with("https://") || url.starts_with("http://");
  if (!is_http || curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK)
    return wrong_url(url, "a URL such as https://pacs.example/dicom-web");
  if (!part(CURLUPART_USER).empty() || !part(CURLUPART_PASSWORD).empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "a URL with a login cannot be used, expected one without, and --http-login FILE"};
  }
  if (!part(CURLUPART_QUERY).empty() || !part(CURLUPART_FRAGMENT).empty())
    return wrong_url(url, "a URL without ? and #");
  if (!login.empty() && part(CURLUPART_SCHEME) == "http" && !is_local(part(CURLUPART_HOST)))
    return wrong_url(url, "https, since a login would cross the network unencrypted");
  DicomWebPeer peer{.url = url, .login = std::move(login)};
  while (peer.url.ends_with('/')) peer.url.pop_back();
  if (peer.url.ends_with("/studies")) return wrong_url(url, "the root of the service, without /studies");
  return peer;
}

Result<std::string> read_http_login(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} cannot be read, expected a file with a login in its first line",
                             printable(path.string()))};
  }
  while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
  const std::size_t colon = line.find(':');
  const bool is_login = line.starts_with(kBearer) || (colon != std::string::npos && colon > 0);
  if (is_login && is_printable(line)) return line;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} has no login, expected USER:PASSWORD or Bearer TOKEN in its first line",
                           printable(path.string()))};
}

std::string shown(const DicomWebPeer& peer) {
  return printable(peer.url);
}

Result<StoreOutcome> outcome_of_answer(long status, const std::string& body) {
  constexpr long kOk = 200;
  constexpr long kAccepted = 202;  // some objects; here there is one
  constexpr long kConflict = 409;
  if (status == 0)
    return StoreOutcome::of_peer(StoreOutcome::State::kNotSent,
                                 fmt::format("the connection broke ({})", body));
  if (status == kOk || status == kAccepted || status == kConflict) {
    if (const unsigned reason = failure_reason(body); reason != 0)
      return outcome_of_status(static_cast<std::uint16_t>(reason));
    if (status == kOk) return StoreOutcome::of_peer(StoreOutcome::State::kStored, "");
    if (status == kAccepted)
      return StoreOutcome::of_peer(StoreOutcome::State::kStored, "stored with a warning");
  }
  for (const long refused : {kConflict, 400L, 413L, 415L, 422L}) {
    if (status == refused)
      return StoreOutcome::of_peer(StoreOutcome::State::kRefused,
                                   fmt::format("it refuses the object, HTTP status {}", status));
  }
  constexpr long kBusy = 429;
  constexpr long kServerErrors = 500;
  if (status == kBusy || status >= kServerErrors)
    return StoreOutcome::of_peer(StoreOutcome::State::kNotSent,
                                 fmt::format("it cannot store now, HTTP status {}", status));
  if (status == 401 || status == 403) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("it refuses the login, or wants one, HTTP status {}, expected --http-login FILE",
                             status)};
  }
  return Error{ErrorCode::kUnavailable,
               fmt::format("HTTP status {}, expected the URL of a DICOMweb service", status)};
}

Result<std::vector<StoreOutcome>> store_by_web(const DicomWebPeer& peer,
                                               std::span<const std::filesystem::path> files,
                                               const std::atomic<bool>& stop) {
  const auto named = [&peer](const Error& error) {
    return Error{error.code, fmt::format("{}: {}", shown(peer), error.message)};
  };
  std::vector<StoreOutcome> outcomes(files.size());
  Transfer transfer(peer, "/studies", stop);
  for (std::size_t at = 0; at < files.size() && !stop; ++at) {
    const auto is_dicom = is_dicom_file(files[at]);
    if (!is_dicom || !*is_dicom) {
      outcomes[at] = is_dicom ? StoreOutcome::local(StoreOutcome::State::kRefused, "the file is not DICOM")
                              : StoreOutcome::local(StoreOutcome::State::kNotSent, is_dicom.error().message);
      continue;
    }
    const auto answer = transfer.send_file(files[at]);
    if (stop) break;  // it was cut off
    const auto outcome =
        answer ? outcome_of_answer(answer->status, answer->body) : Result<StoreOutcome>(answer.error());
    if (!outcome && at == 0) return named(outcome.error());
    outcomes[at] =
        outcome ? *outcome : StoreOutcome::of_peer(StoreOutcome::State::kNotSent, outcome.error().message);
    if (!outcome) break;
  }
  return outcomes;
}

Result<void> check_web(const DicomWebPeer& peer) {
  const std::atomic<bool> never = false;
  Transfer transfer(peer, "/studies?limit=1", never);
  const auto answer = transfer.ask();
  constexpr long kNoContent = 204;
  if (answer && (answer->status == 200 || answer->status == kNoContent)) return {};
  if (!answer) return Error{answer.error().code, fmt::format("{}: {}", shown(peer), answer.error().message)};
  const auto outcome = outcome_of_answer(answer->status, answer->body);
  std::string problem = fmt::format("HTTP status {}, expected the URL of a DICOMweb service", answer->status);
  if (!outcome) problem = outcome.error().message;
  if (answer->status == 0) problem = outcome->sentence;
  return Error{ErrorCode::kUnavailable, fmt::format("{}: {}", shown(peer), problem)};
}

}  // namespace fanlight
