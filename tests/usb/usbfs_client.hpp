// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/usbdevice_fs.h>
#include <umockdev.h>

#include <cstdint>
#include <deque>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tests/usb/g_ref.hpp"

namespace fanlight::test {

/// A USB request block submitted by a client, and its result.
class Urb {
 public:
  /// nullptr where the client's memory cannot be read.
  static std::unique_ptr<Urb> submitted(UMockdevIoctlData* argument);

  unsigned long address() const {
    return data_->client_addr;
  }  ///< address in the client, which identifies it
  std::uint8_t type() const { return block().type; }
  std::uint8_t endpoint() const { return block().endpoint; }
  std::size_t length() const { return static_cast<std::size_t>(block().buffer_length); }

  /// Control transfers only: the setup packet and its data.
  std::span<std::uint8_t> control_buffer() const;

  /// Bulk transfers: the unused part of the client's buffer, and the used length.
  std::span<std::uint8_t> room() { return std::span(received_).subspan(received_bytes_); }
  void received(std::size_t bytes) { received_bytes_ += bytes; }
  void lose_received() { received_bytes_ = 0; }

  /// `status` is 0 or a negative errno. `bytes`: for a control transfer without its setup packet.
  void finish(int status, std::size_t bytes);
  void finish(int status) { finish(status, received_bytes_); }

  /// Copies it to the client's memory as the answer to REAPURB; false on failure.
  bool give_back(UMockdevIoctlData* argument);

 private:
  const usbdevfs_urb& block() const { return *reinterpret_cast<const usbdevfs_urb*>(data_->data); }

  GRef<UMockdevIoctlData> data_;
  GRef<UMockdevIoctlData> control_data_;
  std::vector<std::uint8_t> received_;
  std::size_t received_bytes_ = 0;
};

/// One open file of the device node: its pending URBs and those to be reaped, in the order of submission and
/// completion. Ioctl thread.
class UsbfsClient {
 public:
  explicit UsbfsClient(UMockdevIoctlClient* client) : client_(new_ref(client)) {}

  bool is(const UMockdevIoctlClient* client) const { return client_.get() == client; }

  bool is_open() const { return umockdev_ioctl_client_get_connected(client_.get()) != FALSE; }

  std::list<std::unique_ptr<Urb>>& under_way() { return under_way_; }
  const std::list<std::unique_ptr<Urb>>& under_way() const { return under_way_; }
  Urb& submit(std::unique_ptr<Urb> urb);
  /// `urb` has ended; its fields contain the result.
  void finished(Urb& urb);
  /// Ends it with ENOENT; false where no pending URB has that address.
  bool discard(unsigned long address);

  /// Answers a REAPURBNDELAY: with a finished URB, or ENODEV once `gone`, or else EAGAIN. The last two
  /// answers are delayed until `now_us` + 1 ms or until a URB is finished, because libusb asks again at once.
  void reap(bool gone, std::int64_t now_us);
  /// Sends a delayed answer if it is due.
  void answer_held(bool gone, std::int64_t now_us);
  std::optional<std::int64_t> held_until_us() const { return held_until_us_; }

  bool claimed = false;

 private:
  bool give_finished();

  GRef<UMockdevIoctlClient> client_;
  std::list<std::unique_ptr<Urb>> under_way_;
  std::deque<std::unique_ptr<Urb>> finished_;
  std::optional<std::int64_t> held_until_us_;  // a REAPURBNDELAY is delayed
};

}  // namespace fanlight::test
