// SPDX-License-Identifier: Apache-2.0
// Control pipe and bulk pipe of GadgetProbe.

#include <poll.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "proto/base/clock.hpp"
#include "tests/usb_vm/gadget_probe.hpp"

namespace fanlight::test {

namespace {

constexpr std::uint8_t kVendorIn = USB_TYPE_VENDOR | USB_RECIP_INTERFACE | USB_DIR_IN;
constexpr std::uint8_t kVendorOut = USB_TYPE_VENDOR | USB_RECIP_INTERFACE | USB_DIR_OUT;
constexpr std::int64_t kNsInMs = 1'000'000;
// Longer than the protocol's limit for an answer.
constexpr std::int64_t kTooLateNs = 600 * kNsInMs;
// Resets the model as its stop request does, but without a host.
constexpr auto kStop = static_cast<std::uint8_t>(probe::Request::kStop);

/// Blocks until one of the two is readable, at most timeout_ms; -1: without limit.
void wait_for(int file, int other, int timeout_ms) {
  std::array<pollfd, 2> files{pollfd{.fd = file, .events = POLLIN}, pollfd{.fd = other, .events = POLLIN}};
  poll(files.data(), files.size(), timeout_ms);
}

}  // namespace

// Control pipe.

void GadgetProbe::serve_control(const std::stop_token& stop) {
  const std::stop_callback wake_up(stop, [this] { control_bell_.ring(); });
  for (;;) {
    wait_for(function_.events(), control_bell_.file_descriptor(), -1);
    if (stop.stop_requested()) return;
    const auto event = function_.next_event();
    if (!event) continue;
    if (event->type == FUNCTIONFS_SETUP && wait_while_mute(event->u.setup, stop)) {
      serve(event->u.setup);
    } else if (event->type == FUNCTIONFS_DISABLE) {
      // Reset by the host, or unplugged.
      const std::lock_guard lock(core_->mutex);
      core_->model->control_out(kStop, {}, now_ns());
      end_stream();
    }
  }
}

/// While the probe is mute, a request is answered too late, after the host has given up. False when the
/// thread must end.
bool GadgetProbe::wait_while_mute(const usb_ctrlrequest& request, const std::stop_token& stop) {
  std::unique_lock lock(core_->mutex);
  const bool for_identity = request.bRequestType == kVendorIn &&
                            request.bRequest == static_cast<std::uint8_t>(probe::Request::kIdentity);
  if (for_identity && std::exchange(core_->late_identity, false))
    core_->mute_until_ns = now_ns() + kTooLateNs;
  const std::int64_t mute_ns = core_->mute_until_ns - now_ns();
  lock.unlock();
  if (mute_ns > 0) control_bell_.wait(mute_ns);
  return !stop.stop_requested();
}

void GadgetProbe::serve(const usb_ctrlrequest& request) {
  const bool ours = request.wValue == 0 && request.wIndex == 0;
  if (ours && request.bRequestType == kVendorIn) {
    serve_in(request);
  } else if (ours && request.bRequestType == kVendorOut) {
    serve_out(request);
  } else {
    function_.stall(request);
  }
}

void GadgetProbe::serve_in(const usb_ctrlrequest& request) {
  std::unique_lock lock(core_->mutex);
  const auto answer = core_->model->control_in(request.bRequest);
  // Unlocked, because the host may never take the answer.
  lock.unlock();
  if (answer) {
    function_.answer(std::span(*answer).first(std::min<std::size_t>(answer->size(), request.wLength)));
  } else {
    function_.stall(request);
  }
}

void GadgetProbe::serve_out(const usb_ctrlrequest& request) {
  std::array<std::uint8_t, sizeof(std::uint32_t)> room{};
  if (request.wLength > room.size()) {
    function_.stall(request);
    return;
  }
  const bool has_data = request.wLength > 0;
  const auto data =
      has_data ? function_.take(std::span(room).first(request.wLength)) : std::span(room).first(0);
  std::unique_lock lock(core_->mutex);
  const bool taken = core_->model->control_out(request.bRequest, data, now_ns());
  // Start and stop empty the pipe.
  if (taken && !has_data) end_stream();
  lock.unlock();
  pipe_bell_.ring();
  if (has_data) return;
  if (taken) {
    function_.accept();
  } else {
    function_.stall(request);
  }
}

// Bulk pipe.

void GadgetProbe::end_stream() {
  writes_->cancel();
  begun_bytes_ = 0;
  owes_empty_packet_ = false;
}

void GadgetProbe::serve_pipe(const std::stop_token& stop) {
  const std::stop_callback wake_up(stop, [this] { pipe_bell_.ring(); });
  while (!stop.stop_requested()) {
    const std::int64_t again_ns = fill_pipe();
    const std::int64_t wait_ns = std::max<std::int64_t>(again_ns - now_ns(), 0);
    const bool for_ever = again_ns == std::numeric_limits<std::int64_t>::max();
    wait_for(writes_->bell(), pipe_bell_.file_descriptor(),
             for_ever ? -1 : static_cast<int>((wait_ns + kNsInMs - 1) / kNsInMs));
    pipe_bell_.wait(0);
  }
}

/// Writes the available data. Returns the time of the next data; never, where only a request or the end of a
/// write can produce it.
std::int64_t GadgetProbe::fill_pipe() {
  constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  const std::lock_guard lock(core_->mutex);
  ProbeModel& model = *core_->model;
  while (writes_->free() > 0 && !core_->plug_wish) {
    if (std::exchange(owes_empty_packet_, false)) {
      if (!writes_->write(0)) return kNever;
      continue;
    }
    if (begun_bytes_ == 0 && model.between_frames()) {
      for (const Fault& fault : core_->script.before_frame(model.frames_offered(), now_ns())) {
        core_->carry_out(fault, now_ns());
        core_->changed.notify_all();
      }
      if (core_->plug_wish) return kNever;
    }
    const ProbeModel::Filled filled = model.fill(writes_->room().subspan(begun_bytes_), now_ns());
    const std::size_t bytes = begun_bytes_ += filled.bytes;
    // Of the transfer faults, a gadget can produce only this one.
    if (filled.bytes > 0 && std::exchange(core_->of_next_transfer, std::nullopt) == FaultKind::kStall) {
      stall();
      continue;
    }
    if (!filled.ended && bytes < BulkWrites::kWriteBytes) return model.ready_at_ns().value_or(kNever);
    begun_bytes_ = 0;
    if (!writes_->write(bytes)) return kNever;
    owes_empty_packet_ = filled.ended && bytes > 0 && bytes % FunctionFs::kPacketBytes == 0;
  }
  return kNever;
}

void GadgetProbe::stall() {
  core_->model->lose_last_fill();
  core_->model->tear();
  end_stream();
  writes_->halt();
}

}  // namespace fanlight::test
