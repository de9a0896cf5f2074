// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/model/probe_protocol.hpp"

namespace fanlight::test {

/// A minimal libusb host: opens an emulated probe, sends requests, and reads its stream with several pending
/// transfers. Its tests test the emulator, not Fanlight's reader. One thread.
class RawReader {
 public:
  struct Transferred {
    libusb_transfer_status status = LIBUSB_TRANSFER_COMPLETED;
    std::vector<std::uint8_t> bytes;
    bool full = false;  ///< filled to the requested length
  };

  RawReader();
  ~RawReader();
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  /// Serial numbers of the plugged-in emulated probes.
  std::vector<std::string> serials();
  /// Opens the probe with this serial number and claims its interface; returns 0 or a libusb error.
  int open(const std::string& serial);
  void close();

  /// Number of bytes, or a libusb error.
  int ask(probe::Request request, std::span<std::uint8_t> answer, unsigned timeout_ms = 1000);
  int tell(probe::Request request, std::span<const std::uint8_t> data = {});

  /// Keeps `transfers` transfers of `bytes` pending, until finish().
  void begin(std::size_t transfers, std::size_t bytes);
  /// The next transfer that ended, in order; nullopt after timeout_ms. It is submitted again, unless its
  /// error ended the stream.
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

/// Reassembles the frames of a stream in which a frame ends its transfer. One thread.
class FrameJoiner {
 public:
  struct Frame {
    probe::FrameHeader header;
    std::vector<std::uint8_t> bytes;  ///< header and pixels
    std::size_t header_bytes = 0;
    bool whole = false;  ///< of the length in its header, with the right checksum
  };
  /// The frame that ended with this transfer, if its header is valid.
  std::optional<Frame> add(const RawReader::Transferred& transferred);
  std::uint64_t without_header() const { return without_header_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint64_t without_header_ = 0;
};

}  // namespace fanlight::test
