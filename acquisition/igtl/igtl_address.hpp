// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "acquisition/sequence/image_orientation.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Which OpenIGTLink server is a source, and what of it.
struct IgtlAddress {
  std::string host;       ///< a name or an address, without brackets
  std::string port;       ///< in decimal
  std::string image;      ///< device name of the images; empty: the first images that can be used
  std::string transform;  ///< device name of the transforms that place them; empty: the one that turns
  ImageOrientation orientation;

  /// "HOST", "HOST:PORT", "[::1]:18944", each with options: ",image=NAME", ",transform=NAME",
  /// ",orientation=MF". kInvalidArgument names what is wrong.
  static Result<IgtlAddress> parse(std::string_view text);

  /// "igtl:HOST:PORT"
  std::string text() const;
};

}  // namespace fanlight
