// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/bulk_writes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace fanlight::test {

Result<std::unique_ptr<BulkWrites>> BulkWrites::open(const std::string& path) {
  std::unique_ptr<BulkWrites> made(new BulkWrites);
  // Without O_NONBLOCK a write would block until a host uses the endpoint.
  made->endpoint_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  made->bell_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (made->endpoint_ < 0 || made->bell_ < 0 || syscall(SYS_io_setup, kWrites, &made->queue_) != 0) {
    return Error{ErrorCode::kUnavailable, fmt::format("{} cannot be written ({}), expected an endpoint of "
                                                      "FunctionFS and room for asynchronous writes",
                                                      path, std::strerror(errno))};
  }
  made->buffers_.resize(kWrites * kWriteBytes);
  for (std::size_t i = 0; i < kWrites; ++i) {
    iocb& write = made->writes_[i];
    write.aio_lio_opcode = IOCB_CMD_PWRITE;
    write.aio_fildes = static_cast<std::uint32_t>(made->endpoint_);
    write.aio_buf = reinterpret_cast<std::uintptr_t>(made->buffers_.data() + i * kWriteBytes);
    write.aio_flags = IOCB_FLAG_RESFD;
    write.aio_resfd = static_cast<std::uint32_t>(made->bell_);
    made->idle_.push_back(&write);
  }
  return made;
}

BulkWrites::~BulkWrites() {
  cancel();
  if (queue_ != 0) syscall(SYS_io_destroy, queue_);
  if (bell_ >= 0) close(bell_);
  if (endpoint_ >= 0) close(endpoint_);
}

std::size_t BulkWrites::free() {
  std::uint64_t rings = 0;
  (void)!read(bell_, &rings, sizeof rings);
  reap(0);
  return idle_.size();
}

void BulkWrites::reap(long least) {
  std::array<io_event, kWrites> ended{};
  const long count = syscall(SYS_io_getevents, queue_, least, ended.size(), ended.data(), nullptr);
  for (long i = 0; i < count; ++i) {
    auto* const write = reinterpret_cast<iocb*>(ended[static_cast<std::size_t>(i)].obj);
    std::erase(under_way_, write);
    idle_.push_back(write);
  }
}

std::span<std::uint8_t> BulkWrites::room() {
  return {reinterpret_cast<std::uint8_t*>(idle_.back()->aio_buf), kWriteBytes};
}

bool BulkWrites::write(std::size_t bytes) {
  iocb* write = idle_.back();
  write->aio_nbytes = bytes;
  if (syscall(SYS_io_submit, queue_, 1, &write) != 1) return false;
  idle_.pop_back();
  under_way_.push_back(write);
  return true;
}

void BulkWrites::cancel() {
  // Newest first: the host must not receive the middle of a frame whose beginning was cancelled.
  for (auto write = under_way_.rbegin(); write != under_way_.rend(); ++write) {
    io_event ignored{};
    syscall(SYS_io_cancel, queue_, *write, &ignored);
  }
  while (!under_way_.empty()) reap(1);
}

void BulkWrites::halt() {
  // In FunctionFS, reading an IN endpoint halts it.
  std::uint8_t nothing = 0;
  (void)!read(endpoint_, &nothing, sizeof nothing);
}

}  // namespace fanlight::test
