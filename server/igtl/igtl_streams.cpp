// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_streams.hpp"

namespace fanlight {

std::optional<IgtlStream> stream_of(std::string_view type, std::string_view device) {
  if (type == "TRANS") type = "TRANSFORM";
  for (std::size_t i = 0; i < kIgtlStreams; ++i) {
    const IgtlStreamName& name = kIgtlStreamNames[i];
    if (name.type == type && (device.empty() || device == name.device)) return static_cast<IgtlStream>(i);
  }
  return std::nullopt;
}

}  // namespace fanlight
