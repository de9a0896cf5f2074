// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/usbfs_device.hpp"

#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>

#include "proto/base/clock.hpp"
#include "tests/usb/usb_descriptors.hpp"

namespace fanlight::test {

namespace {

using Shared = std::shared_ptr<UsbfsDevice>;

constexpr std::int64_t kNsPerUs = 1000;

// Those of an xHCI controller, except mmap: libusb then submits one URB for a transfer of any length. Without
// scatter-gather it divides transfers into dependent URBs of 16 KiB.
constexpr std::uint32_t kAbilities = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                     USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;

std::int64_t now_us() {
  return now_ns() / kNsPerUs;
}

// GLib passes a callback's data between threads under locks of its own, which the thread sanitizer does not
// see. It sees this one.
std::mutex& handover() {
  static std::mutex mutex;
  return mutex;
}
gpointer hand_over(Shared device) {
  const std::lock_guard lock(handover());
  return new Shared(std::move(device));
}
Shared handed_over(gpointer shared) {
  const std::lock_guard lock(handover());
  return *static_cast<Shared*>(shared);
}
void delete_shared(gpointer shared) {
  const std::lock_guard lock(handover());
  delete static_cast<Shared*>(shared);
}
void delete_shared_of_closure(gpointer shared, GClosure* /*closure*/) {
  delete_shared(shared);
}

void connect(gpointer instance, const char* signal, GCallback callback, const Shared& self) {
  g_signal_connect_data(instance, signal, callback, hand_over(self), delete_shared_of_closure,
                        static_cast<GConnectFlags>(0));
}

/// The structure at an ioctl's argument; nullptr where the client has none there.
template <typename T>
GRef<UMockdevIoctlData> pointed_to(UMockdevIoctlData* argument) {
  return GRef<UMockdevIoctlData>(umockdev_ioctl_data_resolve(argument, 0, sizeof(T), nullptr));
}
template <typename T>
std::optional<T> read_argument(UMockdevIoctlData* argument) {
  const auto block = pointed_to<T>(argument);
  if (block == nullptr) return std::nullopt;
  T value;
  std::memcpy(&value, block->data, sizeof(value));
  return value;
}

gboolean dispatch_tick(GSource* source, GSourceFunc callback, gpointer data) {
  g_source_set_ready_time(source, -1);
  return callback(data);
}
GSourceFuncs kTickFunctions = {.prepare = nullptr, .check = nullptr, .dispatch = dispatch_tick};

}  // namespace

GRef<UMockdevIoctlBase> UsbfsDevice::handler() {
  GRef<UMockdevIoctlBase> base(umockdev_ioctl_base_new());
  connect(base.get(), "handle-ioctl", G_CALLBACK(on_ioctl), shared_from_this());
  connect(base.get(), "client-connected", G_CALLBACK(on_connected), shared_from_this());
  return base;
}

void UsbfsDevice::on_connected(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer self) {
  const Shared device = handed_over(self);
  const std::lock_guard lock(device->core_->mutex);
  device->forget_closed();
  device->clients_.emplace_back(client);
  if (device->tick_ == nullptr) device->start_ticking();
}

/// The kernel cancels the URBs of a closed file. umockdev does not report a close, but can be asked.
void UsbfsDevice::forget_closed() {
  clients_.remove_if([](const UsbfsClient& client) { return !client.is_open(); });
}

void UsbfsDevice::start_ticking() {
  tick_ = g_source_new(&kTickFunctions, sizeof(GSource));
  const auto run = [](gpointer self) -> gboolean {
    const Shared device = handed_over(self);
    const std::lock_guard lock(device->core_->mutex);
    device->tick();
    return G_SOURCE_CONTINUE;
  };
  g_source_set_callback(tick_, run, hand_over(shared_from_this()), delete_shared);
  g_source_attach(tick_, g_main_context_get_thread_default());
}

void UsbfsDevice::wake() {
  if (tick_ != nullptr) g_source_set_ready_time(tick_, 0);
}

void UsbfsDevice::tick() {
  forget_closed();
  pump();
  for (UsbfsClient& client : clients_) client.answer_held(gone_, now_us());
  arm_tick();
}

void UsbfsDevice::arm_tick() {
  if (tick_ == nullptr) return;
  std::optional<std::int64_t> next_us;
  const auto consider = [&](std::optional<std::int64_t> at_us) {
    if (at_us && (!next_us || *at_us < *next_us)) next_us = at_us;
  };
  for (const UsbfsClient& client : clients_) {
    consider(client.held_until_us());
    const auto ready_ns = core_->model->ready_at_ns();
    if (waits_for_data(client) && ready_ns) consider(*ready_ns / kNsPerUs + 1);
  }
  g_source_set_ready_time(tick_, next_us.value_or(-1));
}

void UsbfsDevice::gone() {
  gone_ = true;
  bool first_bulk = true;
  for (UsbfsClient& client : clients_) {
    while (!client.under_way().empty()) {
      Urb& urb = *client.under_way().front();
      const bool silent = urb.type() == USBDEVFS_URB_TYPE_BULK && std::exchange(first_bulk, false);
      urb.finish(silent ? -EPROTO : -ESHUTDOWN);
      client.finished(urb);
    }
  }
  wake();
}

gboolean UsbfsDevice::on_ioctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* request, gpointer self) {
  const Shared device = handed_over(self);
  const std::lock_guard lock(device->core_->mutex);
  device->forget_closed();
  const auto client =
      std::ranges::find_if(device->clients_, [&](const UsbfsClient& each) { return each.is(request); });
  if (client == device->clients_.end()) return FALSE;
  if (umockdev_ioctl_client_get_request(request) == USBDEVFS_REAPURBNDELAY) {
    device->pump();
    client->reap(device->gone_, now_us());
  } else {
    const int error = device->perform(*client, umockdev_ioctl_client_get_request(request),
                                      umockdev_ioctl_client_get_arg(request));
    umockdev_ioctl_client_complete(request, error == 0 ? 0 : -1, error);
  }
  device->arm_tick();
  return TRUE;
}

/// 0 or an errno.
int UsbfsDevice::perform(UsbfsClient& client, unsigned long request, UMockdevIoctlData* argument) {
  if (gone_) return ENODEV;
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      const auto block = pointed_to<std::uint32_t>(argument);
      if (block == nullptr) return EFAULT;
      std::memcpy(block->data, &kAbilities, sizeof(kAbilities));
      return 0;
    }
    case USBDEVFS_CLAIMINTERFACE:
      return claim(client, read_argument<std::uint32_t>(argument));
    case USBDEVFS_DISCONNECT_CLAIM: {
      const auto asked = read_argument<usbdevfs_disconnect_claim>(argument);
      return claim(client, asked ? std::optional(asked->interface) : std::nullopt);
    }
    case USBDEVFS_RELEASEINTERFACE:
      return std::exchange(client.claimed, false) ? 0 : EINVAL;
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
      return 0;
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
      return ENODATA;  // no kernel driver is bound
    case USBDEVFS_RESETEP:
    case USBDEVFS_CLEAR_HALT:
      if (read_argument<std::uint32_t>(argument) != kEmulatedBulkEndpoint) return ENOENT;
      core_->halted = false;
      return 0;
    case USBDEVFS_RESET:
      core_->model->unplugged();
      core_->halted = false;
      return 0;
    case USBDEVFS_SUBMITURB:
      return submit(client, argument);
    case USBDEVFS_DISCARDURB: {
      unsigned long address = 0;
      std::memcpy(&address, argument->data, sizeof(address));
      return client.discard(address) ? 0 : EINVAL;
    }
    default:
      return ENOTTY;
  }
}

int UsbfsDevice::claim(UsbfsClient& client, std::optional<std::uint32_t> interface) {
  if (!interface) return EFAULT;
  if (*interface != 0) return ENOENT;
  const bool taken = std::ranges::any_of(
      clients_, [&](const UsbfsClient& each) { return each.claimed && &each != &client; });
  if (taken) return EBUSY;
  client.claimed = true;
  return 0;
}

}  // namespace fanlight::test
