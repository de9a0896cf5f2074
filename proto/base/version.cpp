// SPDX-License-Identifier: Apache-2.0
#include "proto/base/version.hpp"

namespace fanlight {

const char* version() {
  return FANLIGHT_VERSION;
}

}  // namespace fanlight
