// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/frame_pipe.hpp"

#include <utility>

namespace fanlight {

namespace {

// Longest wait for one event of the bus while reads are being cancelled.
constexpr std::int64_t kLastEventsUs = 20'000;

}  // namespace

bool FramePipe::start(const UsbProbe& probe) {
  const std::uint32_t taken = reads_.start(probe.handle(), probe.endpoint());
  // None: the probe has just gone. The caller counts a loss.
  if (taken > 0) counters_.transfers_refused.add(config_.transfers - taken);
  return taken > 0;
}

void FramePipe::end(const UsbBus& bus) {
  reading_ = false;
  unread_ = {};
  parser_.reset();
  reads_.cancel();
  while (!reads_.empty()) {
    while (reads_.front() == nullptr) bus.handle_events(kLastEventsUs);
    reads_.pop();
  }
}

FramePipe::OpenedRead FramePipe::open_read() {
  const TransferQueue::Read& read = *reads_.front();
  reading_ = true;
  unread_ = read.bytes;
  parser_.begin_transfer();
  counters_.bytes_received.add(read.bytes.size());
  if (read.status == LIBUSB_TRANSFER_COMPLETED) counters_.transfers_completed.add();
  return {.status = read.status, .has_bytes = !read.bytes.empty()};
}

FrameParser::Event FramePipe::parse() {
  const FrameParser::Event event = parser_.next(unread_);
  if (event == FrameParser::Event::kMore) close_read();
  return event;
}

void FramePipe::close_read() {
  const TransferQueue::Read* const read = reads_.front();
  const bool is_short = read->bytes.size() < config_.transfer_bytes;
  if (read->status == LIBUSB_TRANSFER_COMPLETED && is_short && parser_.in_frame())
    counters_.transfers_short.add();
  const std::uint64_t skipped = parser_.bytes_skipped();
  counters_.bytes_skipped.add(skipped - std::exchange(skipped_counted_, skipped));
  reading_ = false;
  counters_.transfers_refused.add(reads_.pop());
}

}  // namespace fanlight
