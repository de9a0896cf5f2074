// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "server/access/audit_chain.hpp"

namespace fanlight {

/// Takes the lines of an audit log; a file, or a test in its place. One thread. Calls may block for as long
/// as a disk takes.
class AuditSink {
 public:
  virtual ~AuditSink() = default;

  /// Appends a line with these members (see audit_fields()) to the chain. Returns 0, or an errno: the line
  /// was not written. EAGAIN: a pipe is full now.
  virtual int append(std::string_view fields) = 0;

  /// After EAGAIN: waits until there may be room, at most 100 ms.
  virtual void wait_for_room() = 0;

  /// Makes what was appended outlast a power cut. Returns 0 or an errno. As reopen(), if the file was
  /// removed.
  virtual int sync() = 0;

  /// Whether the next lines can be written for sure, as far as is known. Reserves room for them.
  virtual bool has_room() { return true; }

  /// Continues the chain in a new file if the present one was moved or removed.
  virtual void reopen() = 0;

  /// Sentences for the log of the server since the last call; empty: none.
  virtual std::string take_notice() = 0;

  /// The last line that was appended.
  virtual const AuditPosition& position() const = 0;
};

}  // namespace fanlight
