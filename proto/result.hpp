#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace fanlight {

/// What kind of failure an Error is; the process exit code and the metrics follow from it.
enum class ErrorCode {
  kInvalidArgument,  ///< a value from a person or a client is out of its range
  kBadInput,         ///< a file or a stream is not what it says it is
  kUnsupported,      ///< well formed, but a form that Fanlight does not read
  kNotFound,         ///< a file, a volume or a device that is not there
  kUnavailable,      ///< a resource that is there but not to be had now (a port, memory, a GPU)
  kStopped,          ///< the wait was ended by a stop request; not a fault
  kBroken,           ///< an invariant or a driver failed; the process cannot go on
};

/// One failure: `message` is one sentence for a person that says what was wrong and what was expected.
struct Error {
  ErrorCode code = ErrorCode::kBroken;
  std::string message;
};

/// A value or an Error, with the member names of C++23's std::expected. Reading the wrong side is a
/// programming error and ends the process; it never throws.
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
