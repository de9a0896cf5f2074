// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <stop_token>
#include <utility>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/volume.hpp"
#include "server/codec/encoder_pool.hpp"
#include "server/state/volume_copier.hpp"

namespace fanlight {

/// What a client asks of the fluid at a point.
struct FluidQuestion {
  std::uint64_t volume_id = 0;  ///< of the volume in which the point was chosen
  Point at;                     ///< transducer frame
  double border_db = 0;         ///< moves the border's level; positive: a larger region
};
/// Measures the region of fluid that holds the point. Any thread; may take seconds. std::bad_alloc: no
/// memory.
using FluidMeter = std::function<Result<v1::FluidRegion>(const Volume& volume, const FluidQuestion& question,
                                                         const std::stop_token& stop)>;

/// Measures fluid in the volume that is shown, for clients: on a thread of the lane that is asked, one region
/// after the other. Server thread only.
class FluidDesk {
 public:
  static constexpr std::size_t kMostRequests = 8;  ///< that wait for an answer

  struct Answer {
    std::uint64_t asker = 0;
    v1::FluidReply reply;  ///< without a request id
  };
  /// All must outlive this object, except what the executor runs.
  struct Dependencies {
    FluidMeter measure;  ///< empty: this server measures no fluid
    VolumeCopier& volumes;
    Executor executor;
    std::function<void(const Answer& answer)> answered;
  };
  explicit FluidDesk(Dependencies dependencies) : dependencies_(std::move(dependencies)) {}

  /// Answered later. `asker`: any number. Errors, kUnavailable: too many requests wait, or this server
  /// measures no fluid; kInvalidArgument: a number is not finite or out of range.
  Result<void> request(std::uint64_t asker, const FluidQuestion& question);

  /// The answer is not wanted any more: a request that waits is removed, and a measurement under way ends
  /// soon.
  void forget(std::uint64_t asker);

  /// All ends soon, and nothing begins. Call it before the end of the executor's threads.
  void stop();

 private:
  struct Request {
    std::uint64_t asker = 0;
    FluidQuestion question;
    bool is_wanted = true;  // forget() was not called
  };
  bool begin();
  void copied(VolumeCopier::Copy copy);
  void measure(std::shared_ptr<Volume> volume);
  void refuse(const char* sentence);
  void end(const char* refused, v1::FluidReply* reply = nullptr);
  void answer_first(const char* refused, v1::FluidReply* reply);

  Dependencies dependencies_;
  std::deque<Request> requests_;  // the first is under way
  bool is_busy_ = false;
  std::stop_source stop_;  // of the measurement under way
  bool is_stopped_ = false;
  std::shared_ptr<Volume> copy_;  // its memory is used again while requests wait
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
