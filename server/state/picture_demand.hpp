// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "proto/exchange/audience.hpp"

namespace fanlight {

/// Decides whether pictures are rendered: while a display is connected, a recording is under way, or a script
/// has asked for a picture, and for kLingerNs after that. Also from the start until kLingerNs after the first
/// picture: what takes long once, such as building the pipelines, is then done before a display comes.
/// Acquisition, its accounting and the ring of volumes continue in any case. Pure logic: time is a parameter.
/// Server thread only.
class PictureDemand {
 public:
  static constexpr std::int64_t kLingerNs = 10'000'000'000;

  /// `audience` null: every volume is rendered, with or without viewers.
  explicit PictureDemand(Audience* audience) : audience_(audience) {}

  /// A script has asked for a picture.
  void asked(std::int64_t now_ns);

  /// A picture was shown.
  void picture_shown(std::int64_t now_ns);

  /// Brings the audience up to date. Whether resting() has changed.
  bool update(std::size_t displays, bool recording, std::int64_t now_ns);

  /// No new volume is rendered.
  bool resting() const { return resting_; }

 private:
  Audience* audience_;
  std::optional<std::int64_t> needed_until_ns_;  // absent: no picture was shown yet
  bool resting_ = false;
};

}  // namespace fanlight
