// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_state.hpp"

namespace fanlight {

IgtlState igtl_state(const PictureLiveness::Report& report) {
  using State = PictureLiveness::State;
  igtl::StatusCode code = igtl::StatusCode::kOk;
  if (report.state == State::kWaiting) code = igtl::StatusCode::kNotReady;
  if (report.state == State::kNotLive || report.state == State::kDelayed) code = igtl::StatusCode::kTimeOut;
  return {.code = code, .name = PictureLiveness::name(report.state), .text = report.sentence};
}

}  // namespace fanlight
