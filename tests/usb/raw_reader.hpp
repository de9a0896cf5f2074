#pragma once

#include <libusb.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/probe_protocol.hpp"

namespace fanlight::test {

/// A host that does no more than libusb does: opens an emulated probe, asks it, and takes its stream with
/// transfers in flight. What its tests see is the emulator, not Fanlight's reader. One thread.
class RawReader {
 public:
  struct Transferred {
    libusb_transfer_status status = LIBUSB_TRANSFER_COMPLETED;
    std::vector<std::uint8_t> bytes;
    bool full = false;  ///< as long as it was asked for
  };

  RawReader();
  ~RawReader();
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  /// The serial numbers of the emulated probes that are there.
  std::vector<std::string> serials();
  /// 0 or a libusb error: opens the probe with that serial number and claims its interface.
  int open(const std::string& serial);
  void close();

  /// Bytes, or a libusb error.
  int ask(probe::Request request, std::span<std::uint8_t> answer, unsigned timeout_ms = 1000);
  int tell(probe::Request request, std::span<const std::uint8_t> data = {});

  /// Keeps transfers of that length in flight; finish() ends that.
  void begin(std::size_t transfers, std::size_t bytes);
  /// The next that ended, in order; nullopt after timeout_ms without one. What ended well, or with a fault
  /// that the stream outlives, is in flight again.
  std::optional<Transferred> next(unsigned timeout_ms = 5000);
  void finish();
  std::size_t in_flight() const { return in_flight_; }

  int clear_halt();
  libusb_context* context() const { return context_; }
  libusb_device_handle* handle() const { return handle_; }

 private:
  static void LIBUSB_CALL on_transfer(libusb_transfer* transfer);

  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  std::vector<libusb_transfer*> transfers_;
  std::vector<std::vector<std::uint8_t>> buffers_;
  std::deque<Transferred> ended_;
  std::size_t in_flight_ = 0;
  bool resubmits_ = false;
};

/// Puts the frames of a stream whose transfers end with them together again. One thread.
class FrameJoiner {
 public:
  struct Frame {
    probe::FrameHeader header;
    std::vector<std::uint8_t> bytes;  ///< header and pixels
    std::size_t header_bytes = 0;
    bool whole = false;  ///< as long as it says, with the right checksum
  };
  /// A frame that ended with this transfer, if its header is right.
  std::optional<Frame> add(const RawReader::Transferred& transferred);
  std::uint64_t without_header() const { return without_header_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint64_t without_header_ = 0;
};

}  // namespace fanlight::test
