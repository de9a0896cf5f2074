// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/emulated_bus.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "tests/usb/usb_descriptors.hpp"

namespace fanlight::test {

namespace {

/// Ends the test where umockdev fails.
void check(gboolean done, GError* error) {
  if (done != FALSE) return;
  fmt::print(stderr, "umockdev: {}\n", error != nullptr ? error->message : "failed");
  std::abort();
}

constexpr unsigned kFirstDevice = 2;  // number 1 is the root hub
constexpr unsigned kDevices = 126;    // the highest number is 127

namespace fs = std::filesystem;

void write_file(const fs::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// The device in sysfs, below the testbed's root.
void write_device(const fs::path& root, const EmulatedBus::Plugged& device, unsigned number,
                  const std::string& serial) {
  const fs::path folder = root.string() + device.sysfs_path;
  const auto descriptors = device_and_configuration();
  const std::string_view descriptor_bytes(reinterpret_cast<const char*>(descriptors.data()),
                                          descriptors.size());
  fs::create_directories(folder);
  const std::pair<const char*, std::string> attributes[] = {
      {"busnum", "1"},
      {"devnum", fmt::to_string(number)},
      {"speed", "480"},
      {"bConfigurationValue", "1"},
      {"idVendor", fmt::format("{:04x}", kEmulatedVendor)},
      {"idProduct", fmt::format("{:04x}", kEmulatedProduct)},
      {"serial", serial},
  };
  for (const auto& [name, value] : attributes) write_file(folder / name, value + "\n");
  write_file(folder / "descriptors", descriptor_bytes);
  write_file(folder / "uevent",
             fmt::format("SUBSYSTEM=usb\nDEVTYPE=usb_device\nDEVNAME={}\nBUSNUM=001\nDEVNUM={:03}\n"
                         "PRODUCT={:x}/{:x}/100\nTYPE=0/0/0\n",
                         device.node.substr(5), number, kEmulatedVendor, kEmulatedProduct));
  write_file(root.string() + device.node, descriptor_bytes);
  // A relative link, as in the real sysfs: libudev does not follow links out of /sys.
  const fs::path bus = root / "sys/bus/usb";
  fs::create_directory_symlink(bus.lexically_relative(folder), folder / "subsystem");
  fs::create_directory_symlink(folder.lexically_relative(bus / "devices"),
                               bus / "devices" / folder.filename());
}

void remove_device(const fs::path& root, const EmulatedBus::Plugged& device) {
  const fs::path folder = root.string() + device.sysfs_path;
  std::error_code ignored;
  fs::remove(root / "sys/bus/usb/devices" / folder.filename(), ignored);
  fs::remove(root.string() + device.node, ignored);
  fs::remove_all(folder, ignored);
}

}  // namespace

bool EmulatedBus::preloaded() {
  // umockdev_in_mock_environment() returns false in a preloaded process too.
  void* const library = dlopen("libumockdev-preload.so.0", RTLD_LAZY | RTLD_NOLOAD);
  if (library != nullptr) dlclose(library);
  return library != nullptr;
}

EmulatedBus::EmulatedBus(Udev udev) : udev_(udev), testbed_(umockdev_testbed_new()) {
  gchar* const root = umockdev_testbed_get_root_dir(testbed_.get());
  root_ = root;
  g_free(root);
  // As on a machine with USB and no device.
  fs::create_directories(root_ / "dev/bus/usb/001");
  fs::create_directories(root_ / "sys/bus/usb/devices");
}

unsigned EmulatedBus::new_port() {
  const std::lock_guard lock(mutex_);
  return ++ports_;
}

EmulatedBus::Plugged EmulatedBus::plug(unsigned port, const std::string& serial, UMockdevIoctlBase* handler) {
  const std::lock_guard lock(mutex_);
  const unsigned number = kFirstDevice + plugs_++ % kDevices;
  Plugged device{.sysfs_path = fmt::format("/sys/devices/pci0000:00/0000:00:14.0/usb1/1-{}", port),
                 .node = fmt::format("/dev/bus/usb/001/{:03}", number)};
  // Written directly and in this order. umockdev's own function sends the udev message before the node
  // answers, even without udev, and umockdev ends a program that opens such a node.
  GError* error = nullptr;
  check(umockdev_testbed_attach_ioctl(testbed_.get(), device.node.c_str(), handler, &error), error);
  write_device(root_, device, number, serial);
  if (udev_ == Udev::kOn) umockdev_testbed_uevent(testbed_.get(), device.sysfs_path.c_str(), "add");
  return device;
}

void EmulatedBus::unplug(const Plugged& device) {
  const std::lock_guard lock(mutex_);
  if (udev_ == Udev::kOn) umockdev_testbed_uevent(testbed_.get(), device.sysfs_path.c_str(), "remove");
  remove_device(root_, device);
  umockdev_testbed_detach_ioctl(testbed_.get(), device.node.c_str(), nullptr);
}

}  // namespace fanlight::test
