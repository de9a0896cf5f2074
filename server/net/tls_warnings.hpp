// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/net/tls_context.hpp"

namespace fanlight {

/// A sentence for each thing about the files of a TLS server that works, but not as its owner will want: a
/// certificate that has expired, will within 14 days or is not valid yet; a key that other users of this
/// machine may read. Files that cannot be read give none: make_tls_context() refuses those. Blocks to read.
std::vector<std::string> tls_warnings(const TlsFiles& files);

/// When the first certificate of a PEM file expires, in seconds since 1970; 0 where there is none. Blocks to
/// read.
std::uint64_t certificate_expires_s(const std::filesystem::path& path);

}  // namespace fanlight
