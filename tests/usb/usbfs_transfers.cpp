// SPDX-License-Identifier: Apache-2.0
// Transfers of UsbfsDevice: processing of submitted URBs.

#include <algorithm>
#include <cerrno>
#include <optional>
#include <utility>

#include "proto/base/clock.hpp"
#include "tests/usb/usb_descriptors.hpp"
#include "tests/usb/usbfs_device.hpp"

namespace fanlight::test {

namespace {

constexpr std::size_t kSetupBytes = 8;
constexpr std::uint8_t kIn = 0x80;
constexpr std::uint8_t kVendorIn = 0xC1;  // vendor requests to the interface
constexpr std::uint8_t kVendorOut = 0x41;
constexpr std::uint8_t kStandardIn = 0x80;
constexpr std::uint8_t kGetStatus = 0;
constexpr std::uint8_t kGetDescriptor = 6;

struct Setup {
  std::uint8_t type;
  std::uint8_t request;
  std::uint16_t value;
  std::uint16_t index;
  std::size_t length;
};

Setup setup_of(std::span<const std::uint8_t> bytes) {
  const auto word = [&](std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
  };
  return {.type = bytes[0], .request = bytes[1], .value = word(2), .index = word(4), .length = word(6)};
}

std::optional<std::vector<std::uint8_t>> answer_of(const ProbeModel& model, const Setup& setup) {
  if (setup.type == kStandardIn && setup.request == kGetDescriptor) {
    return descriptor(setup.value, model.config().serial);
  }
  if (setup.type == kStandardIn && setup.request == kGetStatus) return std::vector<std::uint8_t>(2);
  if (setup.type != kVendorIn || setup.value != 0 || setup.index != 0) return std::nullopt;
  return model.control_in(setup.request);
}

}  // namespace

int UsbfsDevice::submit(UsbfsClient& client, UMockdevIoctlData* argument) {
  auto submitted = Urb::submitted(argument);
  if (submitted == nullptr) return EFAULT;
  const std::uint8_t type = submitted->type();
  const bool is_control = type == USBDEVFS_URB_TYPE_CONTROL;
  if (is_control && submitted->length() < kSetupBytes) return EINVAL;
  if (!is_control && type != USBDEVFS_URB_TYPE_BULK) return EINVAL;
  if (!is_control && submitted->endpoint() != kEmulatedBulkEndpoint) return ENOENT;
  Urb& urb = client.submit(std::move(submitted));
  if (is_control) {
    control(client, urb);
  } else {
    pump();
  }
  return 0;
}

void UsbfsDevice::control(UsbfsClient& client, Urb& urb) {
  const auto buffer = urb.control_buffer();
  const Setup setup = setup_of(buffer);
  const auto data = buffer.subspan(kSetupBytes);
  const bool for_identity =
      setup.type == kVendorIn && setup.request == static_cast<std::uint8_t>(probe::Request::kIdentity);
  // An unanswered URB ends when the client discards it.
  if (now_ns() < core_->mute_until_ns) return;
  if (for_identity && std::exchange(core_->late_identity, false)) return;

  std::size_t bytes = 0;
  bool taken = false;
  if ((setup.type & kIn) != 0) {
    const auto answer = answer_of(*core_->model, setup);
    taken = answer.has_value();
    bytes = taken ? std::min({answer->size(), setup.length, data.size()}) : 0;
    if (taken) std::copy_n(answer->begin(), bytes, data.begin());
  } else if (setup.type == kVendorOut && setup.value == 0 && setup.index == 0) {
    bytes = std::min(setup.length, data.size());
    taken = core_->model->control_out(setup.request, data.first(bytes), now_ns());
  }
  urb.finish(taken ? 0 : -EPIPE, taken ? bytes : 0);
  client.finished(urb);
}

bool UsbfsDevice::waits_for_data(const UsbfsClient& client) const {
  const bool able = !gone_ && !core_->halted && !core_->plug_wish;
  return able && std::ranges::any_of(client.under_way(),
                                     [](const auto& urb) { return urb->type() == USBDEVFS_URB_TYPE_BULK; });
}

/// Fills bulk URBs, oldest first, with the available data of the probe.
void UsbfsDevice::pump() {
  if (gone_) return;
  for (UsbfsClient& client : clients_) {
    for (auto at = client.under_way().begin(); at != client.under_way().end();) {
      Urb& urb = **at++;  // it may move to the finished ones
      if (urb.type() != USBDEVFS_URB_TYPE_BULK) continue;
      if (!fill(urb)) return;
      client.finished(urb);
    }
  }
}

/// True: it has ended. False: no more data is available.
bool UsbfsDevice::fill(Urb& urb) {
  ProbeModel& model = *core_->model;
  if (core_->halted) {
    urb.finish(-EPIPE);
    return true;
  }
  if (model.between_frames()) {
    for (const Fault& fault : core_->script.before_frame(model.frames_offered(), now_ns())) {
      core_->carry_out(fault, now_ns());
      core_->changed.notify_all();
    }
  }
  if (core_->plug_wish) return false;
  const ProbeModel::Filled filled = model.fill(urb.room(), now_ns());
  urb.received(filled.bytes);
  if (filled.bytes > 0 && core_->of_next_transfer) {
    fail(urb, *std::exchange(core_->of_next_transfer, std::nullopt));
    return true;
  }
  if (!filled.ended && !urb.room().empty()) return false;
  urb.finish(0);
  return true;
}

void UsbfsDevice::fail(Urb& urb, FaultKind fault) {
  core_->model->lose_last_fill();
  urb.lose_received();
  core_->halted = fault == FaultKind::kStall;
  if (core_->halted) core_->model->tear();
  const int status = fault == FaultKind::kStall      ? -EPIPE
                     : fault == FaultKind::kOverflow ? -EOVERFLOW
                                                     : -EPROTO;
  urb.finish(status);
}

}  // namespace fanlight::test
