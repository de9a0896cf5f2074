// SPDX-License-Identifier: Apache-2.0
// The cost of displays for the server and for each other. The server runs in this process with 10 synthetic
// pictures a second of 512 x 512 instead of a renderer. The displays are separate processes. Prints a table.
// --small is a short run for ctest, which checks counts only.
#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "proto/base/clock.hpp"
#include "tests/support/server_fixture.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;

/// A process whose output goes to this descriptor.
pid_t spawned(std::vector<std::string> command, int out) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  dup2(out, STDOUT_FILENO);
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  execv(arguments.front(), arguments.data());
  _exit(127);
}

/// A process of viewers. It is ended by its process id.
class Viewers {
 public:
  Viewers(const std::string& program, const ServerFixture& fixture, std::vector<std::string> options) {
    std::array<int, 2> pipe_ends{};
    if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    options.insert(options.begin(), {program, "--port", std::to_string(fixture.endpoint().port())});
    pid_ = spawned(options, pipe_ends[1]);
    close(pipe_ends[1]);
    out_ = fdopen(pipe_ends[0], "r");
    if (line() != "ready") throw std::runtime_error("the viewers did not start");
  }
  ~Viewers() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    std::fclose(out_);
  }
  void stop() const { kill(pid_, SIGSTOP); }

  /// Their results, after their time is over.
  json report() { return json::parse(line()); }

 private:
  std::string line() {
    std::string text;
    for (int letter = std::fgetc(out_); letter != EOF && letter != '\n'; letter = std::fgetc(out_)) {
      text += static_cast<char>(letter);
    }
    return text;
  }
  pid_t pid_ = 0;
  std::FILE* out_ = nullptr;
};

/// Shows ten pictures a second until it is destroyed.
class Show {
 public:
  explicit Show(ServerFixture& fixture)
      : thread_([&fixture](const std::stop_token& stop) {
          std::uint64_t id = 0;
          auto due = std::chrono::steady_clock::now();
          while (!stop.stop_requested()) {
            fixture.show_surface(++id);
            std::this_thread::sleep_until(due += std::chrono::milliseconds(100));
          }
        }) {}

 private:
  std::jthread thread_;
};

double resident_mb() {
  std::size_t pages = 0;
  std::size_t resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

struct Options {
  std::string program;
  bool small = false;
};

bool failed = false;

void require(bool holds, const char* what) {
  if (!holds) fmt::print("NOT SO: {}\n", what);
  failed |= !holds;
}

/// CPU use of the server thread in percent of a core while the viewers watch, and the results of the viewers.
std::pair<double, json> watched(const Options& options, ServerFixture& fixture, int count, double seconds) {
  Viewers viewers(options.program, fixture,
                  {"--viewers", std::to_string(count), "--seconds", std::to_string(seconds)});
  const double before_s = fixture.server_processor_s();
  const std::int64_t from_ns = now_ns();
  json report = viewers.report();
  const double share =
      100 * (fixture.server_processor_s() - before_s) * 1e9 / static_cast<double>(now_ns() - from_ns);
  require(report["accounts_exact"], "offered = sent + skipped + unsent, for each session");
  require(report["lost"] == 0, "no viewer is lost");
  return {share, report};
}

void many_viewers(const Options& options, ServerFixture& fixture) {
  const int many = options.small ? 10 : 50;
  const double seconds = options.small ? 3 : 20;
  const auto [alone, one] = watched(options, fixture, 1, seconds);
  const auto [crowded, all] = watched(options, fixture, many + 1, seconds);
  fmt::print(
      "{} viewers more: {:.3f} % of a core each (1: {:.2f} %, all: {:.2f} %); the slowest saw {:.2f} a "
      "second; age p50 "
      "{:.1f}, p99 {:.1f} ms (one alone: {:.1f}, {:.1f})\n",
      many, (crowded - alone) / many, alone, crowded, all["fewest_a_second"].get<double>(),
      all["age_p50_ms"].get<double>(), all["age_p99_ms"].get<double>(), one["age_p50_ms"].get<double>(),
      one["age_p99_ms"].get<double>());
}

void one_stopped(const Options& options, ServerFixture& fixture) {
  const double seconds = options.small ? 9 : 65;
  const auto before = watched(options, fixture, 10, options.small ? 3 : 20).second;
  const std::uint64_t stalled = fixture.counters().sessions_stalled.value();
  const Viewers bad(options.program, fixture, {"--viewers", "1", "--seconds", "1000"});
  bad.stop();
  const auto after = watched(options, fixture, 10, seconds).second;
  fmt::print("one viewer stopped for {:.0f} s: the others' p99 age {:.1f} ms, {:.1f} before; {} dropped\n",
             seconds, after["age_p99_ms"].get<double>(), before["age_p99_ms"].get<double>(),
             fixture.counters().sessions_stalled.value() - stalled);
  // It takes a while until its buffers are full, because small pictures fit.
  if (!options.small)
    require(fixture.counters().sessions_stalled.value() == stalled + 1, "the stopped viewer is dropped");
}

void idle_sockets(const Options& options, ServerFixture& fixture) {
  const int idle = options.small ? 100 : 1000;
  const double seconds = options.small ? 3 : 30;
  const auto before = watched(options, fixture, 10, options.small ? 3 : 20).second;
  const double before_mb = resident_mb();
  Viewers bad(options.program, fixture,
              {"--viewers", "0", "--idle", std::to_string(idle), "--seconds", std::to_string(seconds + 2)});
  const auto after = watched(options, fixture, 10, seconds).second;
  const double after_mb = resident_mb();
  fmt::print(
      "{} idle sockets: the viewers' p99 age {:.1f} ms, {:.1f} before; memory {:.1f} MB, {:.1f} before; {} "
      "opened in all\n",
      idle, after["age_p99_ms"].get<double>(), before["age_p99_ms"].get<double>(), after_mb, before_mb,
      bad.report()["idle_opened"].get<int>());
}

/// Viewers who ask for PNG with the depth map, each in a size of its own, beside ten who take JPEG.
void heavy_viewers(const Options& options, ServerFixture& fixture) {
  const double seconds = options.small ? 3 : 20;
  const auto before = watched(options, fixture, 10, seconds).second;
  for (const int count : {3, 15}) {
    Viewers heavy(options.program, fixture,
                  {"--viewers", std::to_string(count), "--png", "--seconds", std::to_string(seconds)});
    const auto meanwhile = watched(options, fixture, 10, seconds).second;
    const json of_heavy = heavy.report();
    fmt::print(
        "{} viewers with PNG and depth: the others' age p50 {:.1f}, p99 {:.1f} ms ({:.1f}, {:.1f} before), "
        "the "
        "slowest sees {:.2f} a second; the slowest of the {} sees {:.2f}\n",
        count, meanwhile["age_p50_ms"].get<double>(), meanwhile["age_p99_ms"].get<double>(),
        before["age_p50_ms"].get<double>(), before["age_p99_ms"].get<double>(),
        meanwhile["fewest_a_second"].get<double>(), count, of_heavy["fewest_a_second"].get<double>());
    if (options.small) return;
  }
}

/// Slow headers, slow bodies and slow reads of slowhttptest, with a thousand connections each.
void slow_attacks(const Options& options, ServerFixture& fixture) {
  const char* const kProgram = "/usr/bin/slowhttptest";
  if (options.small) return;
  if (access(kProgram, X_OK) != 0) {
    fmt::print("slowhttptest is not installed, and so not run\n");
    return;
  }
  const auto before = watched(options, fixture, 10, 20).second;
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  const std::string url = fmt::format("http://127.0.0.1:{}/", fixture.endpoint().port());
  for (const char* const kind : {"-H", "-B", "-X"}) {
    const double before_mb = resident_mb();
    const pid_t attack =
        spawned({kProgram, kind, "-c", "1000", "-r", "200", "-l", "25", "-i", "2", "-u", url}, nowhere);
    const auto meanwhile = watched(options, fixture, 10, 20).second;
    const double most_mb = resident_mb();
    kill(attack, SIGKILL);
    waitpid(attack, nullptr, 0);
    fmt::print(
        "slowhttptest {}: the viewers' p99 age {:.1f} ms, {:.1f} before; memory {:.1f} MB, {:.1f} before\n",
        kind, meanwhile["age_p99_ms"].get<double>(), before["age_p99_ms"].get<double>(), most_mb, before_mb);
  }
  close(nowhere);
}

int run(int argc, char** argv) {
  CLI::App program("What displays cost the server, and one another");
  Options options;
  program.add_option("--viewers-program", options.program)->required();
  program.add_flag("--small", options.small);
  CLI11_PARSE(program, argc, argv);
  ServerFixture fixture(StreamServer::Config{}, "running", ServerFixture::kSurfaceSize);
  const Show show(fixture);
  many_viewers(options, fixture);
  one_stopped(options, fixture);
  idle_sockets(options, fixture);
  heavy_viewers(options, fixture);
  slow_attacks(options, fixture);
  const ServerCounters& counts = fixture.counters();
  // The last displays have gone, but the server may not have noticed it: each still has a picture that waits
  // and one under way.
  const auto pending = [&] {
    return counts.pictures_offered.value() - counts.pictures_sent.value() - counts.pictures_skipped.value();
  };
  for (int i = 0;
       i < 500 && (pending() != 0 || counts.sessions_closed.value() != counts.sessions_opened.value()); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  fmt::print("{} pictures offered, {} sent, {} skipped\n", counts.pictures_offered.value(),
             counts.pictures_sent.value(), counts.pictures_skipped.value());
  require(pending() == 0, "every offered picture is counted as sent or skipped once its display is gone");
  require(counts.sessions_closed.value() == counts.sessions_opened.value(),
          "every display that left is counted");
  return failed ? 1 : 0;
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  try {
    return fanlight::test::run(argc, argv);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "load_figures: %s\n", failure.what());
    return 1;
  }
}
