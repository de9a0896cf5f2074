// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/survey.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// Passes requests to find the surface to the render thread, one at a time, and its answers back. A request that
/// comes while the render thread looks waits for the next look. Server thread only.
class SurveyDesk {
 public:
  /// Wishes that wait for an answer.
  static constexpr std::size_t kMostWishes = 16;
  /// The asker of the server's own request.
  static constexpr std::uint64_t kServer = 0;

  /// The answer to one wish.
  struct Answer {
    std::uint64_t asker = kServer;
    SurveyResult::Outcome outcome = SurveyResult::Outcome::kNoVolume;
    v1::SurveyReply reply;  ///< without a request id
  };

  /// Both must outlive this object; null: there is no renderer that looks.
  SurveyDesk(Mailbox<SurveyOrder>* orders, Mailbox<SurveyResult>* results)
      : orders_(orders), results_(results) {}

  /// `asker`: any number but kServer. `scene`: the scene in force. Error: kUnavailable where too many requests
  /// wait, or there is no renderer that looks.
  Result<void> wish(std::uint64_t asker, const Scene& scene);

  /// The server's own wish. False where the render thread looks for somebody already, or nobody looks.
  bool look(const Scene& scene);

  /// The answers that have come since the last call. `scene`: as above, for the wishes that waited.
  std::vector<Answer> answers(const Scene& scene);

 private:
  struct Wish {
    std::uint64_t asker = kServer;
    std::uint64_t order = 0;  // 0: waits for the next one
  };
  void order(const Scene& scene);

  Mailbox<SurveyOrder>* orders_;
  Mailbox<SurveyResult>* results_;
  std::vector<Wish> wishes_;
  std::uint64_t ordered_ = 0;  // number of the newest order
  bool looking_ = false;
};

}  // namespace fanlight
