// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/igtl/message_writer.hpp"
#include "server/igtl/igtl_streams.hpp"

namespace fanlight {

/// A whole OpenIGTLink message, shared by all clients that are sent it.
using IgtlMessage = std::shared_ptr<const std::vector<std::uint8_t>>;

/// A message in each version of the header; null where no client wanted it.
struct IgtlMessages {
  IgtlMessage version_1;
  IgtlMessage version_2;

  bool any() const { return version_1 != nullptr || version_2 != nullptr; }
  const IgtlMessage& in(igtl::HeadVersion version) const {
    return version == igtl::HeadVersion::kOne ? version_1 : version_2;
  }
};

/// The streams that clients want in each version.
struct IgtlWanted {
  IgtlStreams version_1;
  IgtlStreams version_2;

  const IgtlStreams& in(igtl::HeadVersion version) const {
    return version == igtl::HeadVersion::kOne ? version_1 : version_2;
  }
  IgtlStreams& in(igtl::HeadVersion version) {
    return version == igtl::HeadVersion::kOne ? version_1 : version_2;
  }
  bool has(IgtlStream stream) const { return version_1.has(stream) || version_2.has(stream); }
  bool any() const { return version_1.any() || version_2.any(); }
  void remove(IgtlStream stream) {
    version_1.set(stream, false);
    version_2.set(stream, false);
  }
};

/// What the messages of one picture or volume have in common.
struct IgtlMessageFacts {
  std::uint64_t utc_ns = 0;  ///< when the last frame of its volume was taken, since 1970
  std::uint32_t id = 0;
  igtl::MetadataItems metadata{};  ///< for version 2
};

/// Writes the messages of a stream that are wanted, all with this content. Any thread. Allocates; bad_alloc
/// passes.
IgtlMessages stream_messages(IgtlStream stream, const IgtlMessageFacts& facts,
                             std::span<const std::uint8_t> content, const IgtlWanted& wanted);

}  // namespace fanlight
