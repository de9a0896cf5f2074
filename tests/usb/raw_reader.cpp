// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/raw_reader.hpp"

#include <chrono>
#include <cstdlib>
#include <utility>

#include "proto/base/crc32c.hpp"
#include "tests/usb/usb_descriptors.hpp"

namespace fanlight::test {

namespace {

constexpr std::uint8_t kVendorIn = 0xC1;
constexpr std::uint8_t kVendorOut = 0x41;

bool is_emulated(libusb_device* device) {
  libusb_device_descriptor found{};
  return libusb_get_device_descriptor(device, &found) == 0 && found.idVendor == kEmulatedVendor &&
         found.idProduct == kEmulatedProduct;
}

std::string serial_of(libusb_device_handle* handle) {
  libusb_device_descriptor found{};
  libusb_get_device_descriptor(libusb_get_device(handle), &found);
  unsigned char text[64] = {};
  const int length = libusb_get_string_descriptor_ascii(handle, found.iSerialNumber, text, sizeof(text));
  return length > 0 ? std::string(text, text + length) : "";
}

/// Calls `visit(handle)` with each emulated probe that opens, until it returns true; the handle then belongs
/// to `visit`.
template <typename Visit>
void visit_probes(libusb_context* context, const Visit& visit) {
  libusb_device** devices = nullptr;
  const auto count = libusb_get_device_list(context, &devices);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    libusb_device_handle* handle = nullptr;
    if (!is_emulated(devices[i]) || libusb_open(devices[i], &handle) != 0) continue;
    if (visit(handle)) break;
    libusb_close(handle);
  }
  libusb_free_device_list(devices, 1);
}

}  // namespace

RawReader::RawReader() {
  if (libusb_init(&context_) != 0) std::abort();
}

RawReader::~RawReader() {
  close();
  libusb_exit(context_);
}

std::vector<std::string> RawReader::serials() {
  std::vector<std::string> found;
  visit_probes(context_, [&](libusb_device_handle* handle) {
    found.push_back(serial_of(handle));
    return false;
  });
  return found;
}

int RawReader::open(const std::string& serial) {
  close();
  visit_probes(context_, [&](libusb_device_handle* handle) {
    if (serial_of(handle) != serial) return false;
    handle_ = handle;
    return true;
  });
  if (handle_ == nullptr) return LIBUSB_ERROR_NOT_FOUND;
  libusb_set_auto_detach_kernel_driver(handle_, 1);
  return libusb_claim_interface(handle_, 0);
}

void RawReader::close() {
  finish();
  if (handle_ != nullptr) libusb_close(std::exchange(handle_, nullptr));
}

int RawReader::ask(probe::Request request, std::span<std::uint8_t> answer, unsigned timeout_ms) {
  return libusb_control_transfer(handle_, kVendorIn, static_cast<std::uint8_t>(request), 0, 0, answer.data(),
                                 static_cast<std::uint16_t>(answer.size()), timeout_ms);
}

int RawReader::tell(probe::Request request, std::span<const std::uint8_t> data) {
  constexpr unsigned kTimeoutMs = 1000;
  return libusb_control_transfer(handle_, kVendorOut, static_cast<std::uint8_t>(request), 0, 0,
                                 const_cast<std::uint8_t*>(data.data()),
                                 static_cast<std::uint16_t>(data.size()), kTimeoutMs);
}

int RawReader::clear_halt() {
  return libusb_clear_halt(handle_, kEmulatedBulkEndpoint);
}

void RawReader::begin(std::size_t transfers, std::size_t bytes) {
  resubmits_ = true;
  for (std::size_t i = 0; i < transfers; ++i) {
    auto& buffer = buffers_.emplace_back(bytes);
    libusb_transfer* const transfer = libusb_alloc_transfer(0);
    libusb_fill_bulk_transfer(transfer, handle_, kEmulatedBulkEndpoint, buffer.data(),
                              static_cast<int>(bytes), on_transfer, this, 0);
    transfers_.push_back(transfer);
    if (libusb_submit_transfer(transfer) == 0) ++in_flight_;
  }
}

void RawReader::on_transfer(libusb_transfer* transfer) {
  auto& self = *static_cast<RawReader*>(transfer->user_data);
  --self.in_flight_;
  self.ended_.push_back({.status = transfer->status,
                         .bytes = {transfer->buffer, transfer->buffer + transfer->actual_length},
                         .full = transfer->actual_length == transfer->length});
  const bool outlives = transfer->status == LIBUSB_TRANSFER_COMPLETED ||
                        transfer->status == LIBUSB_TRANSFER_ERROR ||
                        transfer->status == LIBUSB_TRANSFER_OVERFLOW;
  if (self.resubmits_ && outlives && libusb_submit_transfer(transfer) == 0) ++self.in_flight_;
}

std::optional<RawReader::Transferred> RawReader::next(unsigned timeout_ms) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::milliseconds(timeout_ms);
  while (ended_.empty() && Clock::now() < until) {
    timeval wait{.tv_sec = 0, .tv_usec = 20'000};
    libusb_handle_events_timeout_completed(context_, &wait, nullptr);
  }
  if (ended_.empty()) return std::nullopt;
  Transferred first = std::move(ended_.front());
  ended_.pop_front();
  return first;
}

void RawReader::finish() {
  resubmits_ = false;
  for (libusb_transfer* transfer : transfers_) libusb_cancel_transfer(transfer);
  while (in_flight_ > 0) {
    timeval wait{.tv_sec = 0, .tv_usec = 20'000};
    libusb_handle_events_timeout_completed(context_, &wait, nullptr);
  }
  for (libusb_transfer* transfer : transfers_) libusb_free_transfer(transfer);
  transfers_.clear();
  buffers_.clear();
  ended_.clear();
}

std::optional<FrameJoiner::Frame> FrameJoiner::add(const RawReader::Transferred& transferred) {
  bytes_.insert(bytes_.end(), transferred.bytes.begin(), transferred.bytes.end());
  if (transferred.full) return std::nullopt;
  Frame frame{.bytes = std::exchange(bytes_, {})};
  if (read_header(frame.bytes, frame.header, frame.header_bytes) != probe::HeaderCheck::kHeader) {
    ++without_header_;
    return std::nullopt;
  }
  const auto pixels = std::span(frame.bytes).subspan(frame.header_bytes);
  frame.whole = pixels.size() == frame.header.payload_bytes && crc32c(pixels) == frame.header.payload_crc32c;
  return frame;
}

}  // namespace fanlight::test
