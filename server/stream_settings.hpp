#pragma once

#include <compare>
#include <cstdint>

#include "proto/fanlight.pb.h"
#include "proto/picture.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// How a session wants its pictures. Two sessions with equal ones share what is encoded for them.
struct StreamSettings {
  enum class Codec : std::uint8_t { kJpeg, kPng, kH264 };
  Codec codec = Codec::kJpeg;
  int quality = 0;               ///< JPEG, 1 to 100; 0 where the bit rate decides
  int bit_rate_kbps = 0;         ///< 0: by quality alone
  std::uint32_t most_width = 0;  ///< pixels, the proportions stay; 0: as rendered
  std::uint32_t most_height = 0;
  double rate_hz = 0;  ///< at most; 0: every picture
  bool with_depth = false;

  /// Whether a picture's code depends on those before it: then all pictures go through one coder, at one
  /// rate.
  bool remembers() const { return codec == Codec::kH264 || bit_rate_kbps > 0; }

  auto operator<=>(const StreamSettings&) const = default;
};

/// Checks what a client asks for and fills in what it leaves to the server. Error, kInvalidArgument: the
/// field and its range.
Result<StreamSettings> parse_stream_request(const v1::StreamRequest& request, int usual_quality);

/// What is in force, as a message.
v1::StreamRequest stream_message(const StreamSettings& settings);

/// Whether a rate has a picture due at `now_ns` after one at `last_ns`: on a grid of time that all sessions
/// share, so that equal rates take the same pictures.
bool picture_due(double rate_hz, std::int64_t last_ns, std::int64_t now_ns);

}  // namespace fanlight
