// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dlfcn.h>

#include <atomic>

namespace fanlight::test {

/// The library function behind an interposed function. Looked up at the first call, which may come before any
/// constructor has run.
template <typename Function>
class NextFunction {
 public:
  /// `version`: of the symbol, for processors with an older version of the same name.
  constexpr explicit NextFunction(const char* name, const char* version = nullptr)
      : name_(name), version_(version) {}

  template <typename... Arguments>
  auto operator()(Arguments... arguments) {
    return found()(arguments...);
  }

 private:
  Function* found() {
    Function* function = function_.load(std::memory_order_acquire);
    if (function != nullptr) return function;
    void* symbol = version_ == nullptr ? nullptr : dlvsym(RTLD_NEXT, name_, version_);
    if (symbol == nullptr) symbol = dlsym(RTLD_NEXT, name_);
    function = reinterpret_cast<Function*>(symbol);
    function_.store(function, std::memory_order_release);
    return function;
  }

  const char* name_;
  const char* version_;
  std::atomic<Function*> function_{nullptr};
};

}  // namespace fanlight::test
