// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "server/access/audit_sink.hpp"

namespace fanlight {

/// Appends lines to a sink in a thread of its own, so that no caller waits for a disk or a pipe. A bounded
/// queue is between them: what does not fit, and what the sink does not take, is counted and becomes an entry
/// of the log as soon as one can be written. Acts of control are synced to the disk at once, all else within
/// a second.
///
/// All methods are for one thread, the caller's. Only wait_until_written() and end() block.
class AuditWriter {
 public:
  static constexpr std::size_t kMostLines = 4096;     ///< in the queue
  static constexpr std::size_t kMostBytes = 4 << 20;  ///< in the queue

  enum class Urgency : std::uint8_t { kWithinASecond, kNow };

  explicit AuditWriter(std::unique_ptr<AuditSink> sink);
  AuditWriter(const AuditWriter&) = delete;
  AuditWriter& operator=(const AuditWriter&) = delete;
  /// end(), with two seconds.
  ~AuditWriter();

  /// Appends a line with these members: see audit_fields().
  void push(std::string fields, Urgency urgency);

  /// Counts a line as lost that there was no memory for.
  void lose() noexcept;

  /// Calls AuditSink::reopen().
  void reopen();

  /// Blocks until all lines are written or lost. Returns false if that takes longer.
  bool wait_until_written(std::chrono::milliseconds most);

  /// Writes what is in the queue, and ends the thread. Returns false if that takes longer: a disk that does
  /// not answer is then left alone with its thread.
  bool end(std::chrono::milliseconds most);

  /// The last line that was written.
  AuditPosition position() const;
  /// Whether the next lines will be written: the sink has room, and lost none of the last ones.
  bool can_write() const;
  /// Lines that were not written.
  std::uint64_t lost() const;
  /// Sentences for the log of the server since the last call; empty: none.
  std::string take_notice();

 private:
  class Work;

  std::shared_ptr<Work> work_;  // also held by the thread, which may outlast this object
  std::thread thread_;
};

}  // namespace fanlight
