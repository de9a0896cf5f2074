// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/usbfs_client.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <utility>

namespace fanlight::test {

namespace {

constexpr std::int64_t kHoldUs = 1000;

}  // namespace

std::unique_ptr<Urb> Urb::submitted(UMockdevIoctlData* argument) {
  auto urb = std::make_unique<Urb>();
  urb->data_.reset(umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr));
  if (urb->data_ == nullptr || urb->block().buffer_length < 0) return nullptr;
  if (urb->type() != USBDEVFS_URB_TYPE_CONTROL) {
    // The client's buffer is resolved only when data is available: resolving copies the whole buffer to and
    // from the client.
    urb->received_.resize(urb->length());
    return urb;
  }
  urb->control_data_.reset(
      umockdev_ioctl_data_resolve(urb->data_.get(), offsetof(usbdevfs_urb, buffer), urb->length(), nullptr));
  return urb->control_data_ != nullptr ? std::move(urb) : nullptr;
}

std::span<std::uint8_t> Urb::control_buffer() const {
  return {control_data_->data, static_cast<std::size_t>(control_data_->data_len)};
}

void Urb::finish(int status, std::size_t bytes) {
  auto& block = *reinterpret_cast<usbdevfs_urb*>(data_->data);
  block.status = status;
  block.actual_length = static_cast<int>(bytes);
}

bool Urb::give_back(UMockdevIoctlData* argument) {
  if (received_bytes_ > 0) {
    const GRef<UMockdevIoctlData> buffer(
        umockdev_ioctl_data_resolve(data_.get(), offsetof(usbdevfs_urb, buffer), received_bytes_, nullptr));
    if (buffer == nullptr) return false;
    std::copy_n(received_.begin(), received_bytes_, buffer->data);
  }
  const GRef<UMockdevIoctlData> pointer(umockdev_ioctl_data_resolve(argument, 0, sizeof(void*), nullptr));
  return pointer != nullptr && umockdev_ioctl_data_set_ptr(pointer.get(), 0, data_.get()) != FALSE;
}

Urb& UsbfsClient::submit(std::unique_ptr<Urb> urb) {
  return *under_way_.emplace_back(std::move(urb));
}

void UsbfsClient::finished(Urb& urb) {
  const auto at = std::ranges::find(under_way_, &urb, &std::unique_ptr<Urb>::get);
  finished_.push_back(std::move(*at));
  under_way_.erase(at);
}

bool UsbfsClient::discard(unsigned long address) {
  const auto at = std::ranges::find(under_way_, address, [](const auto& urb) { return urb->address(); });
  if (at == under_way_.end()) return false;
  (*at)->finish(-ENOENT);
  finished(**at);
  return true;
}

bool UsbfsClient::give_finished() {
  if (finished_.empty()) return false;
  const std::unique_ptr<Urb> urb = std::move(finished_.front());
  finished_.pop_front();
  held_until_us_.reset();
  const bool given = urb->give_back(umockdev_ioctl_client_get_arg(client_.get()));
  umockdev_ioctl_client_complete(client_.get(), given ? 0 : -1, given ? 0 : EFAULT);
  return true;
}

void UsbfsClient::reap(bool gone, std::int64_t now_us) {
  held_until_us_ = now_us + kHoldUs;
  answer_held(gone, now_us);
}

void UsbfsClient::answer_held(bool gone, std::int64_t now_us) {
  if (!held_until_us_ || give_finished() || now_us < *held_until_us_) return;
  held_until_us_.reset();
  umockdev_ioctl_client_complete(client_.get(), -1, gone ? ENODEV : EAGAIN);
}

}  // namespace fanlight::test
