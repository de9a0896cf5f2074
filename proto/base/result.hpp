// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace fanlight {

/// Kind of failure of an Error; it determines the process exit code and the metrics.
enum class ErrorCode {
  kInvalidArgument,  ///< a value from a user or a client is out of its range
  kBadInput,         ///< the content of a file or a stream is wrong
  kUnsupported,  ///< well formed, but not in a form that Fanlight can use, such as frames without geometry
  kNotFound,     ///< a file, a volume or a device does not exist
  kUnavailable,  ///< a resource exists but is not available now (a port, memory, a GPU)
  kStopped,      ///< a stop request ended the wait; no fault
  kBroken,       ///< an invariant or a driver failed; the process cannot continue
  kLost,         ///< the GPU was lost, or does not answer; a new device may serve
};

/// A failure. `message` is one sentence for a user: what was wrong and what was expected.
struct Error {
  ErrorCode code = ErrorCode::kBroken;
  std::string message;
};

/// A value or an Error, with the member names of C++23's std::expected. Never throws: reading the absent side
/// is a programming error and ends the process.
template <typename T>
class [[nodiscard]] Result {
 public:
  // NOLINTBEGIN(google-explicit-constructor): `return value;` and `return Error{...};` are the point.
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}
  // NOLINTEND(google-explicit-constructor)

  bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  T& value() & { return checked<0>(); }
  const T& value() const& { return const_cast<Result*>(this)->template checked<0>(); }
  T&& value() && { return std::move(checked<0>()); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const { return const_cast<Result*>(this)->template checked<1>(); }

 private:
  template <std::size_t kIndex>
  auto& checked() {
    auto* held = std::get_if<kIndex>(&state_);
    if (held == nullptr) std::abort();
    return *held;
  }

  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool has_value() const { return !error_.has_value(); }
  explicit operator bool() const { return has_value(); }
  const Error& error() const {
    if (!error_) std::abort();
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace fanlight
