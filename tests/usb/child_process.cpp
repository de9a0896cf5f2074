// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/child_process.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>

namespace fanlight::test {

namespace {

using Clock = std::chrono::steady_clock;

sigset_t kept_signals() {
  sigset_t kept;
  sigemptyset(&kept);
  for (const int signal : {SIGINT, SIGTERM, SIGCHLD}) sigaddset(&kept, signal);
  return kept;
}

/// The next of the blocked signals; its number is 0 after the time-out.
siginfo_t next_signal(std::optional<Clock::time_point> until) {
  const sigset_t kept = kept_signals();
  siginfo_t came{};
  if (!until) {
    if (sigwaitinfo(&kept, &came) < 0) came.si_signo = 0;
    return came;
  }
  const auto left = std::max(*until - Clock::now(), Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const timespec wait{.tv_sec = seconds.count(), .tv_nsec = std::chrono::nanoseconds(left - seconds).count()};
  if (sigtimedwait(&kept, &came, &wait) < 0) came.si_signo = 0;
  return came;
}

}  // namespace

void ChildProcess::keep_signals() {
  const sigset_t kept = kept_signals();
  pthread_sigmask(SIG_BLOCK, &kept, nullptr);
}

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& command) {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t id = 0;
  const int failure = posix_spawnp(&id, words[0], nullptr, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (failure != 0) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("\"{}\" cannot be started: {}", command[0], std::strerror(failure))};
  }
  return ChildProcess(id);
}

std::optional<int> ChildProcess::status() {
  int status = 0;
  if (waitpid(id_, &status, WNOHANG) != id_) return std::nullopt;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int ChildProcess::wait(std::optional<double> seconds) {
  std::optional<Clock::time_point> until;
  if (seconds)
    until =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  for (;;) {
    if (const auto ended = status()) return *ended;
    const siginfo_t came = next_signal(until);
    if (came.si_signo == 0 && until && Clock::now() >= *until) {
      until.reset();
      kill(id_, SIGTERM);
    }
    // A signal from the terminal reached the command as well.
    const bool typed = came.si_code == SI_KERNEL;
    if ((came.si_signo == SIGINT || came.si_signo == SIGTERM) && !typed) kill(id_, came.si_signo);
  }
}

}  // namespace fanlight::test
