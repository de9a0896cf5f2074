// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "proto/base/result.hpp"

struct srtp_ctx_t_;

namespace fanlight {

/// Bytes of a master key and its salt for AES_CM_128_HMAC_SHA1_80 (RFC 3711, RFC 4568).
inline constexpr std::size_t kSrtpKeyBytes = 16 + 14;

/// Reads a regular file with the key and its salt in base64. Errors: kNotFound, kBadInput; kInvalidArgument
/// where users other than its owner may write it, or users outside of its group read it.
Result<std::vector<std::uint8_t>> read_srtp_key(const std::filesystem::path& path);

/// Encrypts and signs what one sender sends, by libsrtp (BSD licence, kept by Cisco; Janus and browsers'
/// engines descend from it). One thread.
class SrtpContext {
 public:
  /// `key`: kSrtpKeyBytes. kUnavailable: the library refuses.
  static Result<std::unique_ptr<SrtpContext>> create(const std::vector<std::uint8_t>& key);
  ~SrtpContext();
  SrtpContext(const SrtpContext&) = delete;
  SrtpContext& operator=(const SrtpContext&) = delete;

  /// Replaces the packet by its protected form. Returns false where the library fails; the packet must not be
  /// sent then.
  bool protect_rtp(std::vector<std::uint8_t>& packet);
  bool protect_rtcp(std::vector<std::uint8_t>& packet);
  /// Replaces a packet of a receiver that has the same key by its plain form. Returns false, and leaves the
  /// packet as it is, where it is not of this key, or was seen before.
  bool unprotect_rtcp(std::vector<std::uint8_t>& packet);

 private:
  SrtpContext() = default;

  srtp_ctx_t_* outgoing_ = nullptr;
  srtp_ctx_t_* incoming_ = nullptr;
};

}  // namespace fanlight
