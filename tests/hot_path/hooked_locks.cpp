// SPDX-License-Identifier: Apache-2.0
// Interposes the functions that wait for another thread. Doorbell (proto/exchange/doorbell.hpp) uses none of
// them: it reads and polls a descriptor.
#include <pthread.h>

#include "tests/hot_path/hot_threads.hpp"
#include "tests/hot_path/next_function.hpp"

using fanlight::test::check_call;
using fanlight::test::NextFunction;

namespace {

using OnMutex = int(pthread_mutex_t*);
using OnMutexUntil = int(pthread_mutex_t*, const timespec*);
using OnMutexUntilClock = int(pthread_mutex_t*, clockid_t, const timespec*);
using OnReadWrite = int(pthread_rwlock_t*);
using OnCondition = int(pthread_cond_t*, pthread_mutex_t*);
using OnConditionUntil = int(pthread_cond_t*, pthread_mutex_t*, const timespec*);
using OnConditionUntilClock = int(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*);

constinit NextFunction<OnMutex> next_lock("pthread_mutex_lock");
constinit NextFunction<OnMutex> next_trylock("pthread_mutex_trylock");
constinit NextFunction<OnMutexUntil> next_timedlock("pthread_mutex_timedlock");
constinit NextFunction<OnMutexUntilClock> next_clocklock("pthread_mutex_clocklock");
constinit NextFunction<OnReadWrite> next_rdlock("pthread_rwlock_rdlock");
constinit NextFunction<OnReadWrite> next_tryrdlock("pthread_rwlock_tryrdlock");
constinit NextFunction<OnReadWrite> next_wrlock("pthread_rwlock_wrlock");
constinit NextFunction<OnReadWrite> next_trywrlock("pthread_rwlock_trywrlock");
// Without a version, the older functions with another pthread_cond_t are found.
constinit NextFunction<OnCondition> next_wait("pthread_cond_wait", "GLIBC_2.3.2");
constinit NextFunction<OnConditionUntil> next_timedwait("pthread_cond_timedwait", "GLIBC_2.3.2");
constinit NextFunction<OnConditionUntilClock> next_clockwait("pthread_cond_clockwait");

}  // namespace

extern "C" {

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  check_call("pthread_mutex_lock", __builtin_return_address(0));
  return next_lock(mutex);
}

int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  check_call("pthread_mutex_trylock", __builtin_return_address(0));
  return next_trylock(mutex);
}

int pthread_mutex_timedlock(pthread_mutex_t* mutex, const timespec* until) noexcept {
  check_call("pthread_mutex_timedlock", __builtin_return_address(0));
  return next_timedlock(mutex, until);
}

int pthread_mutex_clocklock(pthread_mutex_t* mutex, clockid_t clock, const timespec* until) noexcept {
  check_call("pthread_mutex_clocklock", __builtin_return_address(0));
  return next_clocklock(mutex, clock, until);
}

int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  check_call("pthread_rwlock_rdlock", __builtin_return_address(0));
  return next_rdlock(lock);
}

int pthread_rwlock_tryrdlock(pthread_rwlock_t* lock) noexcept {
  check_call("pthread_rwlock_tryrdlock", __builtin_return_address(0));
  return next_tryrdlock(lock);
}

int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  check_call("pthread_rwlock_wrlock", __builtin_return_address(0));
  return next_wrlock(lock);
}

int pthread_rwlock_trywrlock(pthread_rwlock_t* lock) noexcept {
  check_call("pthread_rwlock_trywrlock", __builtin_return_address(0));
  return next_trywrlock(lock);
}

int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  check_call("pthread_cond_wait", __builtin_return_address(0));
  return next_wait(condition, mutex);
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  check_call("pthread_cond_timedwait", __builtin_return_address(0));
  return next_timedwait(condition, mutex, until);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  check_call("pthread_cond_clockwait", __builtin_return_address(0));
  return next_clockwait(condition, mutex, clock, until);
}

}  // extern "C"
