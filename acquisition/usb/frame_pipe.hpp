// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "acquisition/usb/frame_parser.hpp"
#include "acquisition/usb/transfer_queue.hpp"
#include "acquisition/usb/usb_bus.hpp"
#include "acquisition/usb/usb_probe.hpp"
#include "proto/base/counter.hpp"

namespace fanlight {

/// Bulk pipe of an open probe: the pending reads and the parser of their bytes, with their counters. One
/// thread. Only libusb allocates after construction.
///
/// Use: start() -> { open_read() -> parse() until it closes the read } -> end().
class FramePipe {
 public:
  FramePipe(const TransferQueue::Config& config, ProbeCounters& counters)
      : counters_(counters), config_(config), reads_(config) {}

  /// Submits all reads. False where the system took none: most likely the probe has just gone. Precondition:
  /// empty(). Throws std::bad_alloc.
  bool start(const UsbProbe& probe);
  /// Cancels all reads. Reads that have already ended are still delivered.
  void cancel() { reads_.cancel(); }
  /// Cancels all reads, waits until they have ended, and drops their bytes and the frame begun.
  void end(const UsbBus& bus);
  /// Frees libusb's transfers; see TransferQueue::release(). Precondition: empty().
  void release() { reads_.release(); }

  /// The next bytes do not continue the previous ones. A frame begun is dropped.
  void reset_parser() { parser_.reset(); }

  /// Whether no read is pending.
  bool empty() const { return reads_.empty(); }
  /// Whether the oldest read has ended.
  bool has_ended_read() { return reads_.front() != nullptr; }
  /// Whether a read is open whose bytes are not all parsed.
  bool reading() const { return reading_; }

  /// Status of a read, and whether it has bytes.
  struct OpenedRead {
    libusb_transfer_status status;
    bool has_bytes;
  };
  /// Opens the oldest read for parse(). Precondition: has_ended_read(), not reading().
  OpenedRead open_read();
  /// Parses up to the next event. kMore: all bytes were used; the read is closed and its buffer submitted
  /// again, unless the reads were cancelled. Precondition: reading().
  FrameParser::Event parse();

  /// Of the frame that parse() announced last.
  const probe::FrameHeader& header() const { return parser_.header(); }
  /// See FrameParser::take_pixels().
  void take_pixels(std::span<std::uint8_t> to) { parser_.take_pixels(to); }

 private:
  void close_read();

  ProbeCounters& counters_;
  TransferQueue::Config config_;
  TransferQueue reads_;
  FrameParser parser_;
  std::uint64_t skipped_counted_ = 0;     // of parser_.bytes_skipped()
  std::span<const std::uint8_t> unread_;  // of the oldest read
  bool reading_ = false;                  // the oldest read is open
};

}  // namespace fanlight
