#pragma once

#include <cstdint>
#include <string>

#include "proto/result.hpp"

namespace fanlight::test {

/// A USB device that this machine plays itself, described to the kernel through configfs: vendor 1209,
/// product 0001, one configuration with one FunctionFS function. Needs root, a configfs under /sys and a USB
/// device controller, here dummy_hcd's, whose other end is a host controller of the same machine. One thread
/// at a time.
///
/// Life: created unplugged -> plug() -> unplug() -> plug() -> ... A destroyed one is unplugged; its folders
/// in configfs stay for the next.
class ConfigfsGadget {
 public:
  /// kUnavailable where the kernel does not let it.
  static Result<ConfigfsGadget> create(const std::string& serial);
  ~ConfigfsGadget();
  ConfigfsGadget(ConfigfsGadget&& other) noexcept;
  ConfigfsGadget& operator=(ConfigfsGadget&&) = delete;

  /// What its FunctionFS is mounted by.
  static constexpr const char* kFunction = "probe";

  /// To the controller's bus; FunctionFS must have its descriptors by then. False where the kernel refuses;
  /// nothing happens where it is plugged in already.
  bool plug();
  /// With whatever is under way.
  void unplug();

 private:
  explicit ConfigfsGadget(std::string controller) : controller_(std::move(controller)) {}

  std::string controller_;
  bool plugged_ = false;
};

}  // namespace fanlight::test
