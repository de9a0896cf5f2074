// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/transfer_queue.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace fanlight {

TransferQueue::TransferQueue(const Config& config)
    : transfer_bytes_(config.transfer_bytes),
      buffers_(new std::uint8_t[std::size_t{config.transfers} * config.transfer_bytes]),
      slots_(config.transfers) {
  waiting_.reserve(std::size_t{2} * config.transfers);
}

TransferQueue::~TransferQueue() {
  release();
}

void TransferQueue::release() {
  for (Slot& slot : slots_) libusb_free_transfer(std::exchange(slot.transfer, nullptr));
}

std::uint32_t TransferQueue::start(libusb_device_handle* handle, std::uint8_t endpoint) {
  cancelled_ = false;
  std::uint32_t taken = 0;
  for (Slot& slot : slots_) {
    if (slot.transfer == nullptr) slot.transfer = libusb_alloc_transfer(0);
    if (slot.transfer == nullptr) throw std::bad_alloc();
    std::uint8_t* const buffer =
        buffers_.get() + static_cast<std::size_t>(&slot - slots_.data()) * transfer_bytes_;
    // No time-out: it would end all pending reads at the same moment without a benefit. UsbSource watches the
    // clock instead.
    libusb_fill_bulk_transfer(slot.transfer, handle, endpoint, buffer, static_cast<int>(transfer_bytes_),
                              &TransferQueue::ended, &slot, 0);
    if (submit(slot) == Outcome::kTaken) ++taken;
  }
  return taken;
}

TransferQueue::Outcome TransferQueue::submit(Slot& slot) {
  slot.done = false;
  const int failure = libusb_submit_transfer(slot.transfer);
  slot.idle = failure != LIBUSB_SUCCESS;
  if (failure == LIBUSB_ERROR_NO_DEVICE) return Outcome::kGone;
  if (slot.idle) return Outcome::kRefused;
  if (waiting_.size() == waiting_.capacity()) {
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_begin_));
    waiting_begin_ = 0;
  }
  waiting_.push_back(&slot);
  return Outcome::kTaken;
}

void LIBUSB_CALL TransferQueue::ended(libusb_transfer* transfer) {
  static_cast<Slot*>(transfer->user_data)->done = true;
}

const TransferQueue::Read* TransferQueue::front() {
  if (empty()) return nullptr;
  const Slot& slot = *waiting_[waiting_begin_];
  if (!slot.done) return nullptr;
  front_ = {.status = slot.transfer->status,
            .bytes = {slot.transfer->buffer, static_cast<std::size_t>(slot.transfer->actual_length)}};
  return &front_;
}

std::uint32_t TransferQueue::pop() {
  Slot& popped = *waiting_[waiting_begin_++];
  popped.idle = true;
  if (cancelled_) return 0;
  std::uint32_t refused = submit(popped) == Outcome::kRefused ? 1 : 0;
  // One at a time: where the system is short of memory, each attempt costs a system call.
  const auto idle = std::ranges::find(slots_, true, &Slot::idle);
  if (refused == 0 && idle != slots_.end() && submit(*idle) == Outcome::kRefused) ++refused;
  return refused;
}

void TransferQueue::cancel() {
  cancelled_ = true;
  for (std::size_t at = waiting_begin_; at < waiting_.size(); ++at) {
    if (!waiting_[at]->done) libusb_cancel_transfer(waiting_[at]->transfer);
  }
}

}  // namespace fanlight
