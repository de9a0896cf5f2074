// SPDX-License-Identifier: Apache-2.0
#include "proto/base/thread_owner.hpp"

#ifdef FANLIGHT_CHECK_THREADS
#include <cstdio>
#include <cstdlib>

namespace fanlight {

void ThreadOwner::check() const {
  thread_local char mark = 0;
  const void* owner = nullptr;
  if (owner_.compare_exchange_strong(owner, &mark, std::memory_order_relaxed) || owner == &mark) return;
  std::fputs("an object is used by two threads, expected by the one that its documentation names\n", stderr);
  std::abort();
}

}  // namespace fanlight
#endif
