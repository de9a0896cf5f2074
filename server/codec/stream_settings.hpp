// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/picture.hpp"
#include "server/codec/picture_mark.hpp"

namespace fanlight {

/// How the pictures of a session are encoded. Sessions with equal settings share the encodings.
struct StreamSettings {
  enum class Codec : std::uint8_t { kJpeg, kPng, kH264, kSurface };
  Codec codec = Codec::kJpeg;
  int quality = 0;               ///< of JPEG, 1 to 100; 0: the bit rate decides
  int bit_rate_kbps = 0;         ///< 0: fixed quality
  std::uint32_t most_width = 0;  ///< in pixels; both 0: the usual size. The proportions stay
  std::uint32_t most_height = 0;
  double rate_hz = 0;  ///< most pictures a second; 0: every picture
  bool with_depth = false;
  PictureMark mark = PictureMark::kNone;  ///< of pictures that are shown without what describes them

  /// Whether the encoding of a picture depends on the pictures before it. Then all pictures must go through
  /// one coder, at one rate.
  bool remembers() const { return codec == Codec::kH264 || bit_rate_kbps > 0; }

  bool has_size() const { return most_width > 0 || most_height > 0; }

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes the zero inside <=> for a pointer
  auto operator<=>(const StreamSettings&) const = default;
};

/// Checks the request of a client and fills in the fields that it leaves to the server. Error,
/// kInvalidArgument: the field and its range.
Result<StreamSettings> parse_stream_request(const v1::StreamRequest& request, int default_quality);

/// The settings as a message.
v1::StreamRequest stream_message(const StreamSettings& settings);

/// Whether a picture is due at `now_ns` if the last one was at `last_ns`. The due times lie on a grid that
/// all sessions share, so that sessions with equal rates take the same pictures.
bool picture_due(double rate_hz, std::int64_t last_ns, std::int64_t now_ns);

}  // namespace fanlight
