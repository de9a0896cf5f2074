#pragma once

#include <linux/usb/functionfs.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "proto/result.hpp"

namespace fanlight::test {

/// The probe's interface in FunctionFS: its descriptors and its control pipe. One thread at a time.
class FunctionFs {
 public:
  /// Of a SuperSpeed endpoint: the only speed that it is described for.
  static constexpr std::size_t kPacketBytes = 1024;

  /// Mounts the function and tells the kernel what the interface looks like. kUnavailable where that fails.
  static Result<FunctionFs> mount(const std::string& function);
  ~FunctionFs();
  FunctionFs(FunctionFs&& other) noexcept;
  FunctionFs& operator=(FunctionFs&&) = delete;

  /// The file of the bulk IN endpoint.
  std::string endpoint_path() const { return folder_ + "/ep1"; }

  /// For poll(): readable when there is an event.
  int events() const { return control_; }
  /// The next event, waiting for it; nullopt where the one before it was overtaken by a new request.
  std::optional<usb_functionfs_event> next_event() const;

  // What is done with a request (event FUNCTIONFS_SETUP). All wait until the host has taken it.
  void answer(std::span<const std::uint8_t> data) const;
  void accept() const;  ///< one without data
  /// The data of an OUT request. The host believes it taken when this returns: the kernel leaves no way to
  /// look at the data and then stall.
  std::span<const std::uint8_t> take(std::span<std::uint8_t> room) const;
  void stall(const usb_ctrlrequest& request) const;

 private:
  explicit FunctionFs(std::string folder) : folder_(std::move(folder)) {}

  std::string folder_;
  bool mounted_ = false;
  int control_ = -1;
};

}  // namespace fanlight::test
