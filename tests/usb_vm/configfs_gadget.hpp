// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/base/result.hpp"

namespace fanlight::test {

/// A USB device emulated by this machine, described to the kernel through configfs: vendor 1209, product
/// 0001, one configuration with one FunctionFS function. Needs root, a configfs under /sys and a USB device
/// controller, here of dummy_hcd, whose other end is a host controller of the same machine. One thread at a
/// time.
///
/// Life: created unplugged -> plug() -> unplug() -> plug() -> ... The destructor unplugs; its configfs
/// folders stay for the next one.
class ConfigfsGadget {
 public:
  /// kUnavailable where the kernel refuses.
  static Result<ConfigfsGadget> create(const std::string& serial);
  ~ConfigfsGadget();
  ConfigfsGadget(ConfigfsGadget&& other) noexcept;
  ConfigfsGadget& operator=(ConfigfsGadget&&) = delete;

  /// Name by which its FunctionFS is mounted.
  static constexpr const char* kFunction = "probe";

  /// Connects it to the controller's bus; FunctionFS must have its descriptors. False where the kernel
  /// refuses; no effect where it is plugged in.
  bool plug();
  /// With all pending transfers.
  void unplug();

 private:
  explicit ConfigfsGadget(std::string controller) : controller_(std::move(controller)) {}

  std::string controller_;
  bool plugged_ = false;
};

}  // namespace fanlight::test
