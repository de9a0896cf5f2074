// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "proto/igtl/text_bodies.hpp"
#include "server/state/picture_liveness.hpp"

namespace fanlight {

/// What a STATUS message says.
struct IgtlState {
  igtl::StatusCode code = igtl::StatusCode::kOk;
  std::string name;  ///< one word or two
  std::string text;  ///< a sentence
};

/// OK while the picture shows what it is meant to show; not ready before the first one; timed out where it is
/// old.
IgtlState igtl_state(const PictureLiveness::Report& report);

}  // namespace fanlight
