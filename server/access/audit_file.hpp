// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "server/access/audit_sink.hpp"

namespace fanlight {

/// The file of an audit log, which this object alone may append to. Also a pipe or a device, whose chain
/// restarts with each object. One thread at a time.
class AuditFile : public AuditSink {
 public:
  /// Opens the file, or creates it with access for its owner only. Reads its end, not the whole of it. A last
  /// line without a line end, as a power cut leaves it, is moved to FILE-torn-LINE, and an entry of the log
  /// says so. `rotate_bytes`: size at which the file is renamed to FILE.LINE (the number of its last line)
  /// and a new one continues the chain; 0: never. Blocks; for a pipe that nothing reads, kPipeWait.
  /// Errors: it cannot be written; nothing reads the pipe; another process has it open; its last lines do not
  /// follow each other.
  static constexpr std::uint64_t kReserveBytes = 4 << 20;
  static constexpr std::chrono::seconds kPipeWait{5};
  static Result<std::unique_ptr<AuditFile>> open(const std::filesystem::path& path,
                                                 std::uint64_t rotate_bytes);

  AuditFile(const AuditFile&) = delete;
  AuditFile& operator=(const AuditFile&) = delete;
  ~AuditFile() override;

  int append(std::string_view fields) override;
  void wait_for_room() override;
  int sync() override;
  /// Keeps kReserveBytes of its disk behind the end of the file, where the file system can: nothing else
  /// fills them. False where a quarter of them is left, or the disk has none where it cannot.
  bool has_room() override;
  void reopen() override;
  std::string take_notice() override;
  const AuditPosition& position() const override { return position_; }

 private:
  AuditFile(std::filesystem::path path, std::uint64_t rotate_bytes)
      : path_(std::move(path)), rotate_bytes_(rotate_bytes), rotate_at_bytes_(rotate_bytes) {}
  Result<void> open_alone();
  Result<void> read_end();
  Result<void> set_aside(std::string_view torn, std::uint64_t whole_bytes);
  int finish_last_write();
  std::string rotated_name() const;
  std::string next_name() const;
  /// Removes what a process left that was ended while it rotated.
  void undo_unfinished_rotation() const;
  void rotate();
  void reserve();
  void release_reserve();
  /// Continues the chain in the file `next`, which this object then owns. `named`: called when the first line
  /// is on the disk; returns 0 or an errno. Returns 0, or an errno: then all is as before.
  int continue_in(int next, const nlohmann::json& details, const std::function<int()>& named);
  void add_notice(std::string sentence);

  std::filesystem::path path_;
  std::uint64_t rotate_bytes_;
  std::uint64_t rotate_at_bytes_;  // grows where a rotation failed
  int file_ = -1;
  bool regular_ = false;
  bool torn_ = false;                 // after `bytes_` there is a part of a line that is to be cut off
  std::uint64_t bytes_ = 0;           // whole lines in the file
  std::uint64_t reserved_bytes_ = 0;  // up to here, from the begin of the file
  bool can_reserve_ = true;           // the file system can
  std::string rest_;                  // of a line of which a pipe took a part
  AuditPosition position_;
  std::string notice_;
};

}  // namespace fanlight
