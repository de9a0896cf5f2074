// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace fanlight {

/// Pending reads of a bulk pipe, delivered in the order in which they were submitted. Buffers are allocated
/// once; libusb's transfers with each start after a release. In addition, libusb allocates a few small blocks
/// with each submission. One thread, the one that handles libusb's events.
class TransferQueue {
 public:
  /// 96 reads of 128 KiB are three quarters of the 16 MB that Linux allows for all USB transfers by default
  /// (usbfs_memory_mb). A frame ends its read, so a frame of 512 x 512 pixels takes three reads: 32 frames
  /// are pending, which last 21 ms at 400 MB/s. A frame of 128 x 128 pixels takes one read: 96 frames, or 4
  /// ms.
  struct Config {
    std::uint32_t transfers = 96;
    std::uint32_t transfer_bytes = 128 << 10;
  };

  /// A read that ended: whole, short, or with an error.
  struct Read {
    libusb_transfer_status status;
    std::span<const std::uint8_t> bytes;  ///< includes bytes that arrived before an error
  };

  explicit TransferQueue(const Config& config);
  /// Precondition: empty().
  ~TransferQueue();
  TransferQueue(const TransferQueue&) = delete;
  TransferQueue& operator=(const TransferQueue&) = delete;

  /// Submits as many reads as the system takes and returns their number. Precondition: empty(). Throws
  /// std::bad_alloc.
  std::uint32_t start(libusb_device_handle* handle, std::uint8_t endpoint);

  /// The oldest read once it has ended; nullptr while it is pending or none is.
  const Read* front();

  /// Releases front() and submits its buffer again, unless cancel() was called, and one read that the system
  /// refused before. Returns the number of reads refused now; a device that is gone is no refusal.
  std::uint32_t pop();

  /// Requests the end of all reads; they reach front() as LIBUSB_TRANSFER_CANCELLED, or with another status
  /// if they ended otherwise.
  void cancel();

  /// Frees libusb's transfers. Must be called before their libusb context is destroyed: a transfer holds a
  /// reference to the device of its last submission, and releases it with its next use. Precondition:
  /// empty().
  void release();

  bool empty() const { return waiting_.size() == waiting_begin_; }

 private:
  struct Slot {
    libusb_transfer* transfer = nullptr;
    bool done = false;
    bool idle = true;  // not submitted: the system refused it
  };

  static void LIBUSB_CALL ended(libusb_transfer* transfer);
  enum class Outcome : std::uint8_t { kTaken, kRefused, kGone };
  Outcome submit(Slot& slot);

  std::uint32_t transfer_bytes_;
  std::unique_ptr<std::uint8_t[]> buffers_;
  std::vector<Slot> slots_;
  std::vector<Slot*> waiting_;  // in order of submission, from waiting_begin_ on
  std::size_t waiting_begin_ = 0;
  bool cancelled_ = false;
  Read front_{};
};

}  // namespace fanlight
