// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/exchange/render_link.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// The request that a text stands for: "freeze", "live", "play", "pause", "step" or "step=-2" (volumes),
/// "seek=3" (a volume, from 0), "speed=0.5". kInvalidArgument names all of them.
Result<v1::CineRequest> cine_request(std::string_view text);

/// The reverse, for logs.
std::string cine_words(const v1::CineRequest& request);

/// The cine as the server sees it: keeps its newest state, and passes requests of displays and scripts to the
/// render thread. Server thread only.
class CineProxy {
 public:
  /// `link` must outlive this object.
  explicit CineProxy(RenderLink& link) : link_(link) {}

  /// Passes a request on. Errors: kUnavailable where too many requests wait; kInvalidArgument for a value out
  /// of its range.
  Result<void> request(const v1::CineRequest& request);

  /// The render thread has reported a state.
  void changed(const CineStatus& status) { status_ = status; }

  bool is_frozen() const { return status_.state != CineStatus::State::kLive; }
  /// Of the frozen volume on show; 0 while live.
  std::uint64_t volume_id() const { return status_.volume_id; }
  v1::CineStatus message() const;

 private:
  RenderLink& link_;
  CineStatus status_;
};

}  // namespace fanlight
