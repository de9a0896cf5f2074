// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>
#include <unistd.h>

namespace fanlight {

/// Of threads that take the time that the renderer leaves.
inline constexpr int kBackgroundNiceness = 10;
/// Of threads that prepare and cast volumes: a moved light, the encoder and the network go before them, and
/// get three quarters of a processor that both want.
inline constexpr int kCastNiceness = 5;

/// The calling thread and those that it starts get this priority. Linux has one for each thread; where it is
/// not allowed, it stays.
inline void lower_priority(int niceness = kBackgroundNiceness) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);
}

}  // namespace fanlight
