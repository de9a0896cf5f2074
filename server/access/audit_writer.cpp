// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_writer.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "server/access/audit_entry.hpp"

namespace fanlight {

namespace {

constexpr auto kBetweenSyncs = std::chrono::seconds(1);
constexpr std::size_t kMostNoticeBytes = 4096;

}  // namespace

/// What the two threads share, and the work of the writer's.
class AuditWriter::Work {
 public:
  explicit Work(std::unique_ptr<AuditSink> sink) : sink_(std::move(sink)) {
    look_for_room();
    publish(std::exchange(new_notice_, {}), 0);
  }

  void push(std::string fields, Urgency urgency) {
    const std::scoped_lock lock(mutex_);
    if (queue_.size() >= kMostLines || queue_bytes_ + fields.size() > kMostBytes) {
      ++overflow_;
      ++lost_;
      return;
    }
    queue_bytes_ += fields.size();
    queue_.push_back({.fields = std::move(fields), .urgency = urgency});
    woken_.notify_one();
  }

  void lose() noexcept {
    const std::scoped_lock lock(mutex_);
    ++no_memory_;
    ++lost_;
    woken_.notify_one();
  }

  void ask_for_reopening() {
    const std::scoped_lock lock(mutex_);
    reopening_ = true;
    woken_.notify_one();
  }

  void ask_for_end() {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
    woken_.notify_one();
  }

  bool wait_until_written(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    return idle_.wait_for(lock, most, [this] { return queue_.empty() && !busy_; });
  }

  bool wait_until_ended(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    return idle_.wait_for(lock, most, [this] { return ended_; });
  }

  AuditPosition position() const {
    const std::scoped_lock lock(mutex_);
    return position_;
  }
  bool can_write() const {
    const std::scoped_lock lock(mutex_);
    // What waits must fit into what the sink has reserved, and a disk that does not answer takes nothing.
    constexpr std::size_t kMostWaitingBytes = kMostBytes / 8;
    const bool answers = !busy_ || std::chrono::steady_clock::now() - busy_since_ < std::chrono::seconds(1);
    return can_write_ && answers && queue_bytes_ < kMostWaitingBytes && overflow_ == 0 && no_memory_ == 0 &&
           !ended_;
  }
  std::uint64_t lost() const {
    const std::scoped_lock lock(mutex_);
    return lost_;
  }
  std::string take_notice() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(notice_, {});
  }

  /// The writer's thread.
  void run() {
    std::unique_lock lock(mutex_);
    while (!ended_) {
      wait_for_work(lock);
      Batch batch{.lines = std::exchange(queue_, {}),
                  .overflow = std::exchange(overflow_, 0),
                  .no_memory = std::exchange(no_memory_, 0),
                  .reopen = std::exchange(reopening_, false),
                  .last = ending_};
      queue_bytes_ = 0;
      busy_ = true;
      busy_since_ = std::chrono::steady_clock::now();
      lock.unlock();
      try {
        write(batch);
        look_for_room();
      } catch (const std::bad_alloc&) {
        const std::uint64_t unhandled = batch.lines.size() - batch.handled;
        batch.lost += unhandled;
        gap_ += unhandled;
        gap_failure_ = ENOMEM;
      }
      const std::string notice = std::exchange(new_notice_, {});
      lock.lock();
      publish(notice, batch.lost);
      busy_ = false;
      ended_ = batch.last && queue_.empty();
      idle_.notify_all();
    }
  }

 private:
  struct Line {
    std::string fields;
    Urgency urgency;
  };
  struct Batch {
    std::vector<Line> lines;
    std::uint64_t overflow;   // lines that came after these and did not fit
    std::uint64_t no_memory;  // lines that there was no memory for
    bool reopen;
    bool last;
    std::size_t handled = 0;  // of the lines: written or lost
    std::uint64_t lost = 0;   // of those
  };

  void wait_for_work(std::unique_lock<std::mutex>& lock) {
    const auto has_work = [this] { return ending_ || reopening_ || no_memory_ > 0 || !queue_.empty(); };
    if (unsynced_ || gap_ > 0 || !has_room_) {
      woken_.wait_until(lock, synced_at_ + kBetweenSyncs, has_work);
    } else {
      woken_.wait(lock, has_work);
    }
  }

  void write(Batch& batch) {
    bool sync = batch.last;
    for (const Line& line : batch.lines) {
      const int failure = write_gap() ? append(line.fields) : gap_failure_;
      ++batch.handled;
      if (failure == 0) {
        unsynced_ = true;
        sync = sync || line.urgency == Urgency::kNow;
      } else {
        ++batch.lost;
        add_gap(1, failure);
      }
    }
    if (batch.overflow > 0) add_gap(batch.overflow, 0);
    if (batch.no_memory > 0) add_gap(batch.no_memory, ENOMEM);
    (void)write_gap();
    if (batch.reopen) sink_->reopen();
    if (sync || std::chrono::steady_clock::now() >= synced_at_ + kBetweenSyncs) sync_now();
  }

  /// While a pipe is full, lines wait in the queue, and those that do not fit are lost.
  int append(std::string_view fields) {
    try {
      int failure = sink_->append(fields);
      while (failure == EAGAIN && !is_ending()) {
        sink_->wait_for_room();
        failure = sink_->append(fields);
      }
      return failure;
    } catch (const std::bad_alloc&) {
      return ENOMEM;
    }
  }

  bool is_ending() const {
    const std::scoped_lock lock(mutex_);
    return ending_;
  }

  void look_for_room() {
    const bool had_room = std::exchange(has_room_, sink_->has_room());
    if (had_room && !has_room_)
      add_notice("the disk of the audit log has no room left for more than a few lines");
    if (!had_room && has_room_) add_notice("the disk of the audit log has room again");
    add_notice(sink_->take_notice());
  }

  static std::string reason_of_gap(int failure) {
    return failure == 0 ? "lines arrived faster than they could be written"
                        : std::generic_category().message(failure);
  }

  void add_gap(std::uint64_t lines, int failure) {
    const bool first = gap_ == 0;
    gap_ += lines;
    gap_failure_ = failure;
    if (first) add_notice(fmt::format("the audit log loses lines ({})", reason_of_gap(failure)));
  }

  /// Writes the entry about the lines that are missing, if any. Returns false if that fails.
  bool write_gap() {
    if (gap_ == 0) return true;
    if (const int failure = append_gap()) {
      gap_failure_ = failure;
      return false;
    }
    unsynced_ = true;
    gap_ = 0;
    return true;
  }

  int append_gap() {
    try {
      const nlohmann::json details = {{"count", gap_}, {"because", reason_of_gap(gap_failure_)}};
      return append(audit_fields_of_log(kAuditLost, details));
    } catch (const std::bad_alloc&) {
      return ENOMEM;
    }
  }

  void sync_now() {
    synced_at_ = std::chrono::steady_clock::now();
    const bool due = std::exchange(unsynced_, false);
    const int failure = due ? sink_->sync() : 0;
    if (failure == sync_failure_ || !due) return;
    sync_failure_ = failure;
    if (failure == 0) return;
    const std::string because = std::generic_category().message(failure);
    add_notice(fmt::format("the audit log could not be synced to its disk ({})", because));
    (void)append(audit_fields_of_log("not synced", {{"because", because}}));
  }

  void add_notice(const std::string& sentence) {
    if (sentence.empty()) return;
    new_notice_ += new_notice_.empty() ? sentence : "; " + sentence;
  }

  void publish(const std::string& notice, std::uint64_t not_written) {
    position_ = sink_->position();
    can_write_ = has_room_ && gap_ == 0 && sync_failure_ == 0;
    lost_ += not_written;
    if (notice.empty() || notice_.size() + notice.size() > kMostNoticeBytes) return;
    notice_ += notice_.empty() ? notice : "; " + notice;
  }

  // The writer's thread alone.
  const std::unique_ptr<AuditSink> sink_;
  std::uint64_t gap_ = 0;   // lines lost since the last entry about such
  int gap_failure_ = 0;     // 0: the queue was full
  bool unsynced_ = false;   // lines were written since the last sync
  int sync_failure_ = 0;    // of the last sync
  bool has_room_ = true;    // the sink says so
  std::string new_notice_;  // not published yet
  std::chrono::steady_clock::time_point synced_at_{};

  mutable std::mutex mutex_;
  std::condition_variable woken_;
  std::condition_variable idle_;
  std::vector<Line> queue_;
  std::size_t queue_bytes_ = 0;
  std::uint64_t overflow_ = 0;   // lines that did not fit since the last batch was taken
  std::uint64_t no_memory_ = 0;  // lines that there was no memory for since then
  std::uint64_t lost_ = 0;
  bool can_write_ = true;
  bool reopening_ = false;
  bool ending_ = false;
  bool busy_ = false;
  std::chrono::steady_clock::time_point busy_since_{};
  bool ended_ = false;
  AuditPosition position_;
  std::string notice_;
};

AuditWriter::AuditWriter(std::unique_ptr<AuditSink> sink)
    : work_(std::make_shared<Work>(std::move(sink))), thread_([work = work_] { work->run(); }) {}

AuditWriter::~AuditWriter() {
  (void)end(std::chrono::seconds(2));
}

void AuditWriter::push(std::string fields, Urgency urgency) {
  work_->push(std::move(fields), urgency);
}

void AuditWriter::lose() noexcept {
  work_->lose();
}

void AuditWriter::reopen() {
  work_->ask_for_reopening();
}

bool AuditWriter::wait_until_written(std::chrono::milliseconds most) {
  return work_->wait_until_written(most);
}

bool AuditWriter::end(std::chrono::milliseconds most) {
  if (!thread_.joinable()) return true;
  work_->ask_for_end();
  if (!work_->wait_until_ended(most)) {
    thread_.detach();
    return false;
  }
  thread_.join();
  return true;
}

AuditPosition AuditWriter::position() const {
  return work_->position();
}

bool AuditWriter::can_write() const {
  return work_->can_write();
}

std::uint64_t AuditWriter::lost() const {
  return work_->lost();
}

std::string AuditWriter::take_notice() {
  return work_->take_notice();
}

}  // namespace fanlight
