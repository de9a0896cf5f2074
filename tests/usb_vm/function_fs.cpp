// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/function_fs.hpp"

#include <endian.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "proto/model/probe_protocol.hpp"

namespace fanlight::test {

namespace {

struct Descriptors {
  usb_functionfs_descs_head_v2 head;
  std::uint32_t super_speed_count;
  usb_interface_descriptor interface;
  usb_endpoint_descriptor_no_audio bulk_in;
  usb_ss_ep_comp_descriptor bulk_in_companion;
} __attribute__((packed));

Descriptors descriptors() {
  return {
      .head = {.magic = htole32(FUNCTIONFS_DESCRIPTORS_MAGIC_V2),
               .length = htole32(sizeof(Descriptors)),
               .flags = htole32(FUNCTIONFS_HAS_SS_DESC)},
      .super_speed_count = htole32(3),
      .interface = {.bLength = USB_DT_INTERFACE_SIZE,
                    .bDescriptorType = USB_DT_INTERFACE,
                    .bNumEndpoints = 1,
                    .bInterfaceClass = probe::kInterfaceClass,
                    .bInterfaceSubClass = probe::kInterfaceSubclass,
                    .bInterfaceProtocol = probe::kInterfaceProtocol},
      .bulk_in = {.bLength = USB_DT_ENDPOINT_SIZE,
                  .bDescriptorType = USB_DT_ENDPOINT,
                  .bEndpointAddress = USB_DIR_IN | 1,
                  .bmAttributes = USB_ENDPOINT_XFER_BULK,
                  .wMaxPacketSize = htole16(FunctionFs::kPacketBytes)},
      .bulk_in_companion = {.bLength = USB_DT_SS_EP_COMP_SIZE, .bDescriptorType = USB_DT_SS_ENDPOINT_COMP}};
}

template <typename Block>
bool put(int file, const Block& block) {
  return write(file, &block, sizeof block) == static_cast<ssize_t>(sizeof block);
}

Error refused(const char* what) {
  return {ErrorCode::kUnavailable,
          fmt::format("FunctionFS did not take {} ({}), expected root, the module usb_f_fs and a function in "
                      "configfs",
                      what, std::strerror(errno))};
}

}  // namespace

Result<FunctionFs> FunctionFs::mount(const std::string& function) {
  FunctionFs made("/run/ffs-" + function);
  std::error_code ignored;
  std::filesystem::create_directories(made.folder_, ignored);
  if (::mount(function.c_str(), made.folder_.c_str(), "functionfs", 0, nullptr) != 0)
    return refused("the mount");
  made.mounted_ = true;
  made.control_ = open((made.folder_ + "/ep0").c_str(), O_RDWR | O_CLOEXEC);
  const usb_functionfs_strings_head no_strings{.magic = htole32(FUNCTIONFS_STRINGS_MAGIC),
                                               .length = htole32(sizeof(usb_functionfs_strings_head))};
  if (made.control_ < 0 || !put(made.control_, descriptors()) || !put(made.control_, no_strings))
    return refused("the descriptors");
  return made;
}

FunctionFs::FunctionFs(FunctionFs&& other) noexcept
    : folder_(std::move(other.folder_)),
      mounted_(std::exchange(other.mounted_, false)),
      control_(std::exchange(other.control_, -1)) {}

FunctionFs::~FunctionFs() {
  if (control_ >= 0) close(control_);
  if (mounted_) umount(folder_.c_str());
}

std::optional<usb_functionfs_event> FunctionFs::next_event() const {
  usb_functionfs_event event{};
  if (read(control_, &event, sizeof event) != static_cast<ssize_t>(sizeof event)) return std::nullopt;
  return event;
}

// A failure here means that the host has given up the request, or that the device is gone: the next event
// reports it.

void FunctionFs::answer(std::span<const std::uint8_t> data) const {
  (void)!write(control_, data.data(), data.size());
}

void FunctionFs::accept() const {
  (void)!read(control_, nullptr, 0);
}

std::span<const std::uint8_t> FunctionFs::take(std::span<std::uint8_t> room) const {
  const ssize_t bytes = read(control_, room.data(), room.size());
  return room.first(bytes > 0 ? static_cast<std::size_t>(bytes) : 0);
}

void FunctionFs::stall(const usb_ctrlrequest& request) const {
  // A transfer in the wrong direction is FunctionFS's way to stall.
  if ((request.bRequestType & USB_DIR_IN) != 0) {
    (void)!read(control_, nullptr, 0);
  } else {
    (void)!write(control_, nullptr, 0);
  }
}

}  // namespace fanlight::test
