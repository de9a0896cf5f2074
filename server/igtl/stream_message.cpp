// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/stream_message.hpp"

#include "proto/igtl/timestamp.hpp"

namespace fanlight {

IgtlMessages stream_messages(IgtlStream stream, const IgtlMessageFacts& facts,
                             std::span<const std::uint8_t> content, const IgtlWanted& wanted) {
  const auto message = [&](igtl::HeadVersion version) -> IgtlMessage {
    if (!wanted.in(version).has(stream)) return nullptr;
    igtl::MessageWriter writer;
    auto& bytes = writer.begin({.type = igtl::TypeName(name_of(stream).type),
                                .device = igtl::DeviceName(name_of(stream).device),
                                .timestamp = igtl::timestamp_of(facts.utc_ns),
                                .version = version,
                                .message_id = facts.id,
                                .metadata = facts.metadata});
    bytes.insert(bytes.end(), content.begin(), content.end());
    const auto whole = writer.finish();
    return std::make_shared<const std::vector<std::uint8_t>>(whole.begin(), whole.end());
  };
  return {.version_1 = message(igtl::HeadVersion::kOne), .version_2 = message(igtl::HeadVersion::kTwo)};
}

}  // namespace fanlight
