// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "proto/base/result.hpp"
#include "proto/exchange/replay_link.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// The request that a text stands for: "play", "pause", "step" or "step=-2" (sweeps), "seek=3.5" (seconds),
/// "speed=0.5", "ending=once", "ending=loop" or "ending=to-and-fro". kInvalidArgument names all of them.
Result<v1::ReplayRequest> replay_request(std::string_view text);

/// "once", "loop" or "to-and-fro"; "unknown" for another value.
std::string_view replay_ending_name(v1::ReplayStatus::Ending ending);

/// The reverse, for logs.
std::string replay_words(const v1::ReplayRequest& request);

/// The player of a recording as the server sees it: keeps its newest state, and passes requests of displays
/// and scripts to the acquisition thread. Server thread only.
class ReplayProxy {
 public:
  /// `link` must outlive this object. `path`: of the recording; never sent to clients, see without_path().
  explicit ReplayProxy(ReplayLink& link, std::string path = "") : link_(link), path_(std::move(path)) {}

  /// Passes a request on. Errors: kUnavailable where the source is no recording, or cannot do it;
  /// kInvalidArgument for a value out of its range.
  Result<void> request(const v1::ReplayRequest& request);

  /// Reads the player's newest state. Whether it differs.
  bool update();

  bool is_replay() const { return status_.state != ReplayStatus::State::kAbsent; }
  const ReplayStatus& status() const { return status_; }
  v1::ReplayStatus message() const;

 private:
  ReplayLink& link_;
  std::string path_;
  ReplayStatus status_;
};

}  // namespace fanlight
