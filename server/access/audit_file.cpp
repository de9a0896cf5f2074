// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <utility>

#include "proto/base/file_replacement.hpp"
#include "server/access/audit_entry.hpp"
#include "server/access/digest.hpp"

namespace fanlight {

namespace {

// Read at the start. No line is longer: a message of a display has at most 64 KB.
constexpr std::uint64_t kEndBytes = 512 << 10;
constexpr mode_t kOwnerOnly = S_IRUSR | S_IWUSR;
constexpr int kFileFlags = O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC;

std::string reason_of(int failure) {
  return std::generic_category().message(failure);
}

Error not_opened(const std::filesystem::path& path, int failure) {
  return {ErrorCode::kUnavailable,
          fmt::format("the audit log {} could not be opened ({}), expected a file to append to",
                      path.string(), reason_of(failure))};
}

bool is_same_file(int file, const std::filesystem::path& path) {
  struct stat ours {};
  struct stat named {};
  return ::fstat(file, &ours) == 0 && ::stat(path.c_str(), &named) == 0 && ours.st_ino == named.st_ino &&
         ours.st_dev == named.st_dev;
}

/// Whether the text can be the first part of the line with this number, or what a file system leaves of one.
bool may_be_torn(std::string_view text, std::uint64_t line) {
  const std::string begin = fmt::format("{{\"line\":{},", line);
  const std::size_t common = std::min(begin.size(), text.size());
  return text.substr(0, common) == begin.substr(0, common) ||
         std::ranges::all_of(text, [](char letter) { return letter == '\0'; });
}

Result<std::string> text_at(int file, std::uint64_t offset, std::uint64_t bytes,
                            const std::filesystem::path& path) {
  std::string text(bytes, '\0');
  std::uint64_t done = 0;
  while (done < bytes) {
    const ssize_t part = ::pread(file, text.data() + done, bytes - done, static_cast<off_t>(offset + done));
    if (part < 0) return not_opened(path, errno);
    if (part == 0) break;
    done += static_cast<std::uint64_t>(part);
  }
  text.resize(done);
  return text;
}

std::filesystem::path free_name(const std::string& wanted) {
  std::error_code ignored;
  std::string name = wanted;
  for (int number = 2; std::filesystem::exists(name, ignored); ++number) {
    name = fmt::format("{}-{}", wanted, number);
  }
  return name;
}

}  // namespace

Result<std::unique_ptr<AuditFile>> AuditFile::open(const std::filesystem::path& path,
                                                   std::uint64_t rotate_bytes) {
  std::unique_ptr<AuditFile> made(new AuditFile(path, rotate_bytes));
  if (auto opened = made->open_alone(); !opened) return opened.error();
  if (!made->regular_) return made;
  if (auto read = made->read_end(); !read) return read.error();
  return made;
}

AuditFile::~AuditFile() {
  if (file_ < 0) return;
  release_reserve();
  ::close(file_);
}

Result<void> AuditFile::open_alone() {
  struct stat status {};
  regular_ = ::stat(path_.c_str(), &status) != 0 || S_ISREG(status.st_mode);
  if (!regular_) {
    // A pipe that nothing reads yet is not opened; its reader may start at the same time.
    const auto until = std::chrono::steady_clock::now() + kPipeWait;
    do {
      file_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | O_NONBLOCK);
      if (file_ >= 0) return {};
      if (errno != ENXIO) return not_opened(path_, errno);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    } while (std::chrono::steady_clock::now() < until);
    return Error{ErrorCode::kUnavailable,
                 fmt::format("nothing reads the pipe {} of the audit log, expected a reader within {} s",
                             path_.string(), kPipeWait.count())};
  }
  // Another process that rotates its log gives the name to a new file between our two calls.
  constexpr int kMostTries = 10;
  for (int tries = 0; tries < kMostTries; ++tries) {
    file_ = ::open(path_.c_str(), kFileFlags, kOwnerOnly);
    if (file_ < 0) return not_opened(path_, errno);
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) break;
    std::error_code ignored;
    path_ = std::filesystem::canonical(path_, ignored);
    if (is_same_file(file_, path_)) return {};
    ::close(std::exchange(file_, -1));
  }
  return Error{ErrorCode::kUnavailable,
               fmt::format("another process writes to the audit log {}, expected a file "
                           "for this server only",
                           path_.string())};
}

Result<void> AuditFile::read_end() {
  struct stat status {};
  if (::fstat(file_, &status) != 0) return not_opened(path_, errno);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  const std::uint64_t offset = size - std::min(size, kEndBytes);
  const auto end = text_at(file_, offset, size - offset, path_);
  if (!end) return end.error();
  std::string_view text = *end;
  AuditChain chain(offset == 0 ? AuditChain::Begin::kOfFile : AuditChain::Begin::kAnywhere);
  // The first line may be cut by the offset.
  if (offset > 0) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  for (std::size_t length = text.find('\n'); length != std::string_view::npos; length = text.find('\n')) {
    if (!chain.take(text.substr(0, length))) {
      if (chain.lines() > 0 || offset == 0) return broken_audit_chain(path_, chain.position().line + 1);
      return Error{
          ErrorCode::kBadInput,
          fmt::format("the audit log {} ends with a line that is not an audit entry, expected the log as it "
                      "was written, or a new file",
                      path_.string())};
    }
    text.remove_prefix(length + 1);
  }
  position_ = chain.position();
  undo_unfinished_rotation();
  bytes_ = size - text.size();
  if (text.empty() && (chain.lines() > 0 || size == 0)) return {};
  const bool known = chain.lines() > 0 || offset == 0;
  if (!known || !may_be_torn(text, position_.line + 1)) return broken_audit_chain(path_, position_.line + 1);
  return set_aside(text, bytes_);
}

Result<void> AuditFile::set_aside(std::string_view torn, std::uint64_t whole_bytes) {
  const auto name = free_name(fmt::format("{}-torn-{}", path_.string(), position_.line + 1));
  if (auto kept = replace_file(name, torn, {.mode = kOwnerOnly}); !kept) return kept;
  const nlohmann::json details = {
      {"bytes", torn.size()}, {"file", name.filename().string()}, {"sha256", hex(sha256(torn))}};
  int failure = ::ftruncate(file_, static_cast<off_t>(whole_bytes)) == 0 ? 0 : errno;
  if (failure == 0) failure = append(audit_fields_of_log("a torn last line was set aside", details));
  if (failure == 0) failure = sync();
  if (failure != 0) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the torn last line of the audit log {} could not be cut off ({}), expected a "
                             "file that may be written, and room",
                             path_.string(), reason_of(failure))};
  }
  add_notice(
      fmt::format("the audit log {} ended within line {}; that part was moved to {}, and the log continues",
                  path_.string(), position_.line, name.string()));
  return {};
}

int AuditFile::append(std::string_view fields) {
  if (const int failure = finish_last_write()) return failure;
  struct stat status {};
  if (regular_ && ::fstat(file_, &status) == 0) bytes_ = static_cast<std::uint64_t>(status.st_size);
  const std::string text =
      fmt::format("{{\"line\":{},{},\"follows\":\"{}\"}}\n", position_.line + 1, fields, position_.hash);
  ssize_t written = -1;
  do {
    written = ::write(file_, text.data(), text.size());
  } while (written < 0 && errno == EINTR);
  if (written < 0) return errno;
  if (static_cast<std::size_t>(written) < text.size()) {
    if (regular_) {
      torn_ = true;
      (void)finish_last_write();  // else before the next line
      return ENOSPC;
    }
    rest_ = text.substr(static_cast<std::size_t>(written));
  }
  bytes_ += text.size();
  position_ = {.line = position_.line + 1,
               .hash = hex(sha256(std::string_view(text).substr(0, text.size() - 1)))};
  if (regular_ && rotate_bytes_ > 0 && bytes_ >= rotate_at_bytes_) rotate();
  return 0;
}

void AuditFile::reserve() {
  if (!can_reserve_ || reserved_bytes_ >= bytes_ + kReserveBytes / 2) return;
  if (::fallocate(file_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(bytes_), kReserveBytes) == 0) {
    reserved_bytes_ = bytes_ + kReserveBytes;
  } else if (errno != ENOSPC && errno != EDQUOT && errno != EINTR) {
    can_reserve_ = false;  // the file system does not, or a sandbox
  }
}

/// So that a file that is complete takes no more of the disk than its lines.
void AuditFile::release_reserve() {
  struct stat status {};
  if (regular_ && reserved_bytes_ > 0 && !torn_ && ::fstat(file_, &status) == 0)
    (void)!::ftruncate(file_, status.st_size);
  reserved_bytes_ = 0;
}

bool AuditFile::has_room() {
  if (!regular_) return rest_.empty();
  reserve();
  if (can_reserve_) return reserved_bytes_ >= bytes_ + kReserveBytes / 4;
  struct statvfs disk {};
  return ::fstatvfs(file_, &disk) != 0 || std::uint64_t{disk.f_bavail} * disk.f_frsize >= kReserveBytes;
}

/// An incomplete line would break the chain.
int AuditFile::finish_last_write() {
  if (torn_) {
    if (::ftruncate(file_, static_cast<off_t>(bytes_)) != 0) return errno;
    torn_ = false;
    reserved_bytes_ = 0;
  }
  while (!rest_.empty()) {
    const ssize_t written = ::write(file_, rest_.data(), rest_.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    rest_.erase(0, static_cast<std::size_t>(written));
  }
  return 0;
}

void AuditFile::wait_for_room() {
  pollfd waiting = {.fd = file_, .events = POLLOUT, .revents = 0};
  ::poll(&waiting, 1, 100);
}

int AuditFile::sync() {
  if (!regular_) return 0;
  if (::fdatasync(file_) != 0) return errno;
  // Lines written to a file without a name would be lost when it is closed.
  struct stat status {};
  if (::fstat(file_, &status) == 0 && status.st_nlink == 0) reopen();
  return 0;
}

int AuditFile::continue_in(int next, const nlohmann::json& details, const std::function<int()>& named) {
  const AuditPosition position = position_;
  const int before = std::exchange(file_, next);
  const std::uint64_t rotate_at_bytes = std::exchange(rotate_at_bytes_, UINT64_MAX);  // not within append()
  const std::uint64_t bytes = bytes_;
  const std::uint64_t reserved_bytes = std::exchange(reserved_bytes_, 0);
  ::fdatasync(before);
  int failure = ::flock(next, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK ? EWOULDBLOCK : 0;
  if (failure == 0) failure = append(audit_fields_of_log(kAuditContinues, details));
  if (failure == 0) failure = sync();
  if (failure == 0) failure = named();
  if (failure != 0) {
    ::close(std::exchange(file_, before));
    position_ = position;
    bytes_ = bytes;
    reserved_bytes_ = reserved_bytes;
    rotate_at_bytes_ = rotate_at_bytes;
    torn_ = false;
    return failure;
  }
  struct stat old {};
  if (reserved_bytes > 0 && ::fstat(before, &old) == 0) (void)!::ftruncate(before, old.st_size);
  ::close(before);
  sync_folder_of(path_);
  rotate_at_bytes_ = rotate_bytes_;
  return 0;
}

std::string AuditFile::rotated_name() const {
  return fmt::format("{}.{:012}", path_.string(), position_.line);
}

std::string AuditFile::next_name() const {
  return path_.string() + kAuditNextSuffix;
}

void AuditFile::undo_unfinished_rotation() const {
  ::unlink(next_name().c_str());
  if (is_same_file(file_, rotated_name())) ::unlink(rotated_name().c_str());
}

void AuditFile::rotate() {
  // The old file gets its second name first: at each moment the name of the log is that of a file with lines.
  const std::string old_name = rotated_name();
  const std::string next_name = this->next_name();
  int failure = ::link(path_.c_str(), old_name.c_str()) == 0 ? 0 : errno;
  if (failure == 0) {
    struct stat old {};
    const mode_t mode = ::fstat(file_, &old) == 0 ? old.st_mode & 0777 : kOwnerOnly;
    const int next = ::open(next_name.c_str(), kFileFlags | O_EXCL, mode);
    failure = next < 0
                  ? errno
                  : continue_in(next, {{"file_before", std::filesystem::path(old_name).filename().string()}},
                                [&] { return ::rename(next_name.c_str(), path_.c_str()) == 0 ? 0 : errno; });
    if (failure != 0) {
      ::unlink(next_name.c_str());
      ::unlink(old_name.c_str());
    }
  }
  if (failure == 0) return;
  rotate_at_bytes_ = bytes_ + rotate_bytes_;
  add_notice(fmt::format("the audit log {} could not be rotated ({}) and continues in the same file",
                         path_.string(), reason_of(failure)));
}

void AuditFile::reopen() {
  if (!regular_ || is_same_file(file_, path_)) return;
  struct stat status {};
  const bool absent = ::stat(path_.c_str(), &status) != 0;
  const int next = ::open(path_.c_str(), kFileFlags, kOwnerOnly);
  int failure = next < 0 ? errno : 0;
  if (failure == 0 && ::fstat(next, &status) == 0 && status.st_size > 0) {
    ::close(next);
    failure = EEXIST;
  }
  if (failure == 0) failure = continue_in(next, nullptr, [] { return 0; });
  if (failure == 0) {
    add_notice(fmt::format("the audit log was reopened as a new file {}", path_.string()));
  } else {
    // An empty one would begin a chain of its own when the server starts again.
    if (absent) ::unlink(path_.c_str());
    add_notice(
        fmt::format("the audit log could not be reopened as a new file {} ({}); it continues in the old one, "
                    "expected no file or an empty one",
                    path_.string(), reason_of(failure)));
  }
}

void AuditFile::add_notice(std::string sentence) {
  notice_ += notice_.empty() ? std::move(sentence) : "; " + sentence;
}

std::string AuditFile::take_notice() {
  return std::exchange(notice_, {});
}

}  // namespace fanlight
