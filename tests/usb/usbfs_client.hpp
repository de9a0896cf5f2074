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

/// A request block as a client submitted it, and what came of it.
class Urb {
 public:
  /// nullptr where the client's memory could not be read.
  static std::unique_ptr<Urb> submitted(UMockdevIoctlData* argument);

  unsigned long address() const { return data_->client_addr; }  ///< in the client, its name for it
  std::uint8_t type() const { return block().type; }
  std::uint8_t endpoint() const { return block().endpoint; }
  std::size_t length() const { return static_cast<std::size_t>(block().buffer_length); }

  /// Control only: the setup packet and the data after it.
  std::span<std::uint8_t> control_buffer() const;

  /// Bulk: the room that is left in the client's buffer, and how much of it was used.
  std::span<std::uint8_t> room() { return std::span(received_).subspan(received_bytes_); }
  void received(std::size_t bytes) { received_bytes_ += bytes; }
  void lose_received() { received_bytes_ = 0; }

  /// `status` is 0 or a negative errno. `bytes` are those of a control transfer without its setup packet.
  void finish(int status, std::size_t bytes);
  void finish(int status) { finish(status, received_bytes_); }

  /// Into the client's memory, as the answer to its REAPURB; false where that failed.
  bool give_back(UMockdevIoctlData* argument);

 private:
  const usbdevfs_urb& block() const { return *reinterpret_cast<const usbdevfs_urb*>(data_->data); }

  GRef<UMockdevIoctlData> data_;
  GRef<UMockdevIoctlData> control_data_;
  std::vector<std::uint8_t> received_;
  std::size_t received_bytes_ = 0;
};

/// One opening of the device's node: its URBs under way and those to be reaped, each in the order submitted
/// or finished. Thread of the ioctls.
class UsbfsClient {
 public:
  explicit UsbfsClient(UMockdevIoctlClient* client) : client_(new_ref(client)) {}

  bool is(const UMockdevIoctlClient* client) const { return client_.get() == client; }

  bool is_open() const { return umockdev_ioctl_client_get_connected(client_.get()) != FALSE; }

  std::list<std::unique_ptr<Urb>>& under_way() { return under_way_; }
  const std::list<std::unique_ptr<Urb>>& under_way() const { return under_way_; }
  Urb& submit(std::unique_ptr<Urb> urb);
  /// `urb` is under way; its fields say how it ended.
  void finished(Urb& urb);
  /// Ends it with ENOENT; false where none under way has that address.
  bool discard(unsigned long address);

  /// Answers a REAPURBNDELAY: with a finished URB, or, once `gone`, ENODEV, or else EAGAIN. The last two are
  /// held until `now_us` + 1 ms, or until a URB is finished: libusb asks again at once.
  void reap(bool gone, std::int64_t now_us);
  /// Answers the one that is held where there is something to answer or its time has come.
  void answer_held(bool gone, std::int64_t now_us);
  std::optional<std::int64_t> held_until_us() const { return held_until_us_; }

  bool claimed = false;

 private:
  bool give_finished();

  GRef<UMockdevIoctlClient> client_;
  std::list<std::unique_ptr<Urb>> under_way_;
  std::deque<std::unique_ptr<Urb>> finished_;
  std::optional<std::int64_t> held_until_us_;  // a REAPURBNDELAY waits
};

}  // namespace fanlight::test
