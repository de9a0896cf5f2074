// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/srtp_context.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <srtp2/srtp.h>
#include <sys/stat.h>

#include <fstream>
#include <mutex>
#include <string>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

/// The library's own state is made once.
bool library_ready() {
  static std::once_flag once;
  static bool ready = false;
  std::call_once(once, [] { ready = srtp_init() == srtp_err_status_ok; });
  return ready;
}

srtp_t make_session(std::vector<std::uint8_t> key, srtp_ssrc_type_t sources) {
  srtp_policy_t policy = {};
  srtp_crypto_policy_set_rtp_default(&policy.rtp);
  srtp_crypto_policy_set_rtcp_default(&policy.rtcp);
  policy.ssrc.type = sources;
  policy.key = key.data();
  policy.window_size = 128;
  srtp_t session = nullptr;
  return srtp_create(&session, &policy) == srtp_err_status_ok ? session : nullptr;
}

/// `protect`: one of the library's functions, which work in place and need room behind the packet.
template <typename Protect>
bool in_place(std::vector<std::uint8_t>& packet, srtp_t session, Protect protect) {
  int bytes = static_cast<int>(packet.size());
  packet.insert(packet.end(), SRTP_MAX_TRAILER_LEN + 4, 0);
  const bool done = protect(session, packet.data(), &bytes) == srtp_err_status_ok;
  packet.erase(packet.begin() + bytes, packet.end());
  return done;
}

}  // namespace

Result<std::vector<std::uint8_t>> read_srtp_key(const std::filesystem::path& path) {
  struct stat status {};
  // Looked at before it is opened: a folder opens like a file, a device may have no end, and a pipe no
  // writer.
  const bool is_file = ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
  std::ifstream file;
  if (is_file) file.open(path);
  if (!file.is_open()) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("the file {} cannot be read, expected a file with an SRTP key",
                             printable(path.string()))};
  }
  if ((status.st_mode & (S_IRWXO | S_IWGRP)) != 0) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("the SRTP key in {} has mode {:04o}, so that other users of this machine can use or "
                    "replace it; expected 0640 or 0600 (chmod 600)",
                    printable(path.string()), status.st_mode & 07777)};
  }
  constexpr std::size_t kMostBytes = 1024;
  std::string text(kMostBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' '))
    text.erase(text.size() - 1);
  // 30 bytes are 40 letters, without padding.
  std::vector<std::uint8_t> key(kSrtpKeyBytes);
  const bool good = text.size() == kSrtpKeyBytes / 3 * 4 && text.find('=') == std::string::npos &&
                    EVP_DecodeBlock(key.data(), reinterpret_cast<const unsigned char*>(text.data()),
                                    static_cast<int>(text.size())) == static_cast<int>(kSrtpKeyBytes);
  if (good) return key;
  return Error{ErrorCode::kBadInput, fmt::format("{} has no SRTP key, expected 30 random bytes in base64, as "
                                                 "\"openssl rand -base64 30\" prints them",
                                                 printable(path.string()))};
}

Result<std::unique_ptr<SrtpContext>> SrtpContext::create(const std::vector<std::uint8_t>& key) {
  std::unique_ptr<SrtpContext> context(new SrtpContext());
  if (library_ready() && key.size() == kSrtpKeyBytes) {
    context->outgoing_ = make_session(key, ssrc_any_outbound);
    context->incoming_ = make_session(key, ssrc_any_inbound);
  }
  if (context->outgoing_ == nullptr || context->incoming_ == nullptr)
    return Error{ErrorCode::kUnavailable, "libsrtp refuses to begin a session"};
  return context;
}

SrtpContext::~SrtpContext() {
  if (outgoing_ != nullptr) srtp_dealloc(outgoing_);
  if (incoming_ != nullptr) srtp_dealloc(incoming_);
}

bool SrtpContext::protect_rtp(std::vector<std::uint8_t>& packet) {
  return in_place(packet, outgoing_, srtp_protect);
}

bool SrtpContext::protect_rtcp(std::vector<std::uint8_t>& packet) {
  return in_place(packet, outgoing_, srtp_protect_rtcp);
}

bool SrtpContext::unprotect_rtcp(std::vector<std::uint8_t>& packet) {
  std::vector<std::uint8_t> plain = packet;
  int bytes = static_cast<int>(plain.size());
  if (srtp_unprotect_rtcp(incoming_, plain.data(), &bytes) != srtp_err_status_ok) return false;
  packet.assign(plain.begin(), plain.begin() + bytes);
  return true;
}

}  // namespace fanlight
