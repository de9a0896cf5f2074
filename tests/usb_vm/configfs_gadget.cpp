// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/configfs_gadget.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace fanlight::test {

namespace {

namespace fs = std::filesystem;

const fs::path kGadget = "/sys/kernel/config/usb_gadget/fanlight";
constexpr const char* kEnglish = "strings/0x409";

/// configfs takes a value in one write, and reports an error as its result.
bool set(const fs::path& attribute, const std::string& value) {
  const int file = open((kGadget / attribute).c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool taken = write(file, value.data(), value.size()) == static_cast<ssize_t>(value.size());
  const int reason = errno;
  close(file);
  errno = reason;
  return taken;
}

bool describe(const std::string& serial) {
  const std::string function = fmt::format("functions/ffs.{}", ConfigfsGadget::kFunction);
  for (const std::string& folder :
       {std::string(), std::string(kEnglish), std::string("configs/c.1"), function})
    fs::create_directories(kGadget / folder);
  const fs::path link = kGadget / "configs/c.1" / ConfigfsGadget::kFunction;
  if (!fs::exists(fs::symlink_status(link))) fs::create_symlink(kGadget / function, link);
  return set("idVendor", "0x1209") && set("idProduct", "0x0001") &&
         set(fs::path(kEnglish) / "manufacturer", "Fanlight") &&
         set(fs::path(kEnglish) / "product", "Fanlight gadget probe") &&
         set(fs::path(kEnglish) / "serialnumber", serial);
}

}  // namespace

Result<ConfigfsGadget> ConfigfsGadget::create(const std::string& serial) {
  try {
    const fs::directory_iterator controllers("/sys/class/udc");
    if (controllers == end(controllers)) {
      return Error{ErrorCode::kUnavailable,
                   "this machine has no USB device controller, expected the module dummy_hcd"};
    }
    if (describe(serial)) return ConfigfsGadget(controllers->path().filename());
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the gadget's description was refused ({}), expected a kernel that takes it",
                             std::strerror(errno))};
  } catch (const fs::filesystem_error& error) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("no gadget can be made here ({}), expected root, configfs, and the modules "
                             "libcomposite, usb_f_fs and dummy_hcd",
                             error.what())};
  }
}

ConfigfsGadget::ConfigfsGadget(ConfigfsGadget&& other) noexcept
    : controller_(std::move(other.controller_)), plugged_(std::exchange(other.plugged_, false)) {}

ConfigfsGadget::~ConfigfsGadget() {
  unplug();
}

bool ConfigfsGadget::plug() {
  if (!plugged_) plugged_ = set("UDC", controller_);
  return plugged_;
}

void ConfigfsGadget::unplug() {
  if (std::exchange(plugged_, false)) set("UDC", "\n");
}

}  // namespace fanlight::test
