#pragma once

#include <libusb.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace fanlight {

/// Reads of a bulk pipe that are always under way, and their bytes in the order in which they were asked for.
/// Buffers are allocated once, libusb's own transfers with each start after a release; besides, libusb
/// allocates a few small blocks whenever one is submitted. One thread, the one that handles libusb's events.
class TransferQueue {
 public:
  /// 96 reads of 128 KiB, three quarters of the 16 MB that Linux allows for all USB transfers by default
  /// (usbfs_memory_mb). A frame ends its read, so that one of 512 x 512 pixels takes three: 32 frames are
  /// asked for, which at 400 MB/s come in 21 ms; of frames of 128 x 128 it is 96, or 4 ms.
  struct Config {
    std::uint32_t transfers = 96;
    std::uint32_t transfer_bytes = 128 << 10;
  };

  /// One read that ended: whole, short, or with an error.
  struct Read {
    libusb_transfer_status status;
    std::span<const std::uint8_t> bytes;  ///< also those that came before an error
  };

  explicit TransferQueue(const Config& config);
  /// Precondition: empty().
  ~TransferQueue();
  TransferQueue(const TransferQueue&) = delete;
  TransferQueue& operator=(const TransferQueue&) = delete;

  /// Asks for as many reads as the system takes and returns their number. Precondition: empty(). Throws
  /// std::bad_alloc.
  std::uint32_t start(libusb_device_handle* handle, std::uint8_t endpoint);

  /// The oldest read, once it ended; nullptr while it is under way, or none is.
  const Read* front();

  /// Gives front() back, and asks for its buffer's next read unless `cancel()` was called, and for those that
  /// the system refused before. Returns how many it refuses now; one of a device that is gone is no refusal.
  std::uint32_t pop();

  /// Asks for the end of all reads; they come to front() as LIBUSB_TRANSFER_CANCELLED or as what else they
  /// ended with.
  void cancel();

  /// Lets go of the device. To be called before its libusb context is gone: a transfer holds the device that
  /// it was last submitted to, and would give it back with its next use. Precondition: empty().
  void release();

  bool empty() const { return waiting_.size() == waiting_begin_; }

 private:
  struct Slot {
    libusb_transfer* transfer = nullptr;
    bool done = false;
    bool idle = true;  // not asked for: the system refused it
  };

  static void LIBUSB_CALL ended(libusb_transfer* transfer);
  enum class Outcome : std::uint8_t { kTaken, kRefused, kGone };
  Outcome submit(Slot& slot);

  std::uint32_t transfer_bytes_;
  std::unique_ptr<std::uint8_t[]> buffers_;
  std::vector<Slot> slots_;
  std::vector<Slot*> waiting_;  // in the order asked for, from waiting_begin_ on
  std::size_t waiting_begin_ = 0;
  bool cancelled_ = false;
  Read front_{};
};

}  // namespace fanlight
