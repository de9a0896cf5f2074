// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/aio_abi.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight::test {

/// Writes to an IN endpoint of FunctionFS, several at a time, which the kernel holds until the host reads
/// them. Uses Linux asynchronous I/O, the only way to cancel writes that the host has not read. A write whose
/// length is no multiple of the packet size, or 0, ends the host's transfer. One thread at a time.
class BulkWrites {
 public:
  static constexpr std::size_t kWrites = 16;
  static constexpr std::size_t kWriteBytes = 64 << 10;

  /// kUnavailable where the endpoint or the kernel's queue cannot be opened.
  static Result<std::unique_ptr<BulkWrites>> open(const std::string& path);
  /// Cancels all writes.
  ~BulkWrites();
  BulkWrites(const BulkWrites&) = delete;
  BulkWrites& operator=(const BulkWrites&) = delete;

  /// For poll(): readable when a write has ended since the last free().
  int bell() const { return bell_; }
  /// Number of writes that can be added now.
  std::size_t free();

  /// The buffer of the next write. Precondition: free() was above 0.
  std::span<std::uint8_t> room();
  /// Writes `bytes` bytes of room(), possibly 0. False where no host uses the endpoint.
  bool write(std::size_t bytes);

  /// Cancels what the host has not read.
  void cancel();
  /// Halts the endpoint until the host clears it. Precondition: cancel() was called.
  void halt();

 private:
  BulkWrites() = default;
  void reap(long least);

  int endpoint_ = -1;
  int bell_ = -1;
  aio_context_t queue_ = 0;
  std::array<iocb, kWrites> writes_{};
  std::vector<std::uint8_t> buffers_;
  std::vector<iocb*> idle_;
  std::vector<iocb*> under_way_;  // oldest first
};

}  // namespace fanlight::test
