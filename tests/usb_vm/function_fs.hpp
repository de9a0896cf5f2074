// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/usb/functionfs.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "proto/base/result.hpp"

namespace fanlight::test {

/// The probe's interface in FunctionFS: its descriptors and its control pipe. One thread at a time.
class FunctionFs {
 public:
  /// Packet size of a SuperSpeed endpoint, the only speed described.
  static constexpr std::size_t kPacketBytes = 1024;

  /// Mounts the function and writes the interface's descriptors. kUnavailable on failure.
  static Result<FunctionFs> mount(const std::string& function);
  ~FunctionFs();
  FunctionFs(FunctionFs&& other) noexcept;
  FunctionFs& operator=(FunctionFs&&) = delete;

  /// File of the bulk IN endpoint.
  std::string endpoint_path() const { return folder_ + "/ep1"; }

  /// For poll(): readable when there is an event.
  int events() const { return control_; }
  /// Blocks until the next event; nullopt where a new request replaced the one before.
  std::optional<usb_functionfs_event> next_event() const;

  // Answers to a request (event FUNCTIONFS_SETUP). All block until the host has taken them.
  void answer(std::span<const std::uint8_t> data) const;
  void accept() const;  ///< a request without data
  /// Data of an OUT request. When this returns, the host believes it accepted: the kernel offers no way to
  /// stall after reading the data.
  std::span<const std::uint8_t> take(std::span<std::uint8_t> room) const;
  void stall(const usb_ctrlrequest& request) const;

 private:
  explicit FunctionFs(std::string folder) : folder_(std::move(folder)) {}

  std::string folder_;
  bool mounted_ = false;
  int control_ = -1;
};

}  // namespace fanlight::test
