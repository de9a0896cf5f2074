// What displays cost the server, and one another. The server runs here with pictures of a made surface in
// place of a renderer's, 10 a second, 512 x 512; the displays are processes of their own. Prints a table;
// --small is brief, for ctest, and only its counts decide.
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

#include "proto/clock.hpp"
#include "tests/support/fake_house.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;

/// A process that writes to that descriptor.
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

/// A process of viewers, ended by its id.
class Viewers {
 public:
  Viewers(const std::string& program, const FakeHouse& house, std::vector<std::string> options) {
    std::array<int, 2> pipe_ends{};
    if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    options.insert(options.begin(), {program, "--port", std::to_string(house.endpoint().port())});
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

  /// What they saw, once their time is over.
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

/// Shows ten pictures a second while it lives.
class Show {
 public:
  explicit Show(FakeHouse& house)
      : thread_([&house](const std::stop_token& stop) {
          std::uint64_t id = 0;
          auto due = std::chrono::steady_clock::now();
          while (!stop.stop_requested()) {
            house.show_surface(++id);
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

/// The server thread's share of a core while the viewers look on, percent, and what they saw.
std::pair<double, json> watched(const Options& options, FakeHouse& house, int count, double seconds) {
  Viewers viewers(options.program, house,
                  {"--viewers", std::to_string(count), "--seconds", std::to_string(seconds)});
  const double before_s = house.server_processor_s();
  const std::int64_t from_ns = now_ns();
  json report = viewers.report();
  const double share =
      100 * (house.server_processor_s() - before_s) * 1e9 / static_cast<double>(now_ns() - from_ns);
  require(report["accounts_exact"], "offered = sent + skipped + unsent, for each session");
  require(report["lost"] == 0, "no viewer is lost");
  return {share, report};
}

void many_viewers(const Options& options, FakeHouse& house) {
  const int many = options.small ? 10 : 50;
  const double seconds = options.small ? 3 : 20;
  const auto [alone, one] = watched(options, house, 1, seconds);
  const auto [crowded, all] = watched(options, house, many + 1, seconds);
  fmt::print(
      "{} viewers more: {:.3f} % of a core each (1: {:.2f} %, all: {:.2f} %); the slowest saw {:.2f} a "
      "second; age p50 "
      "{:.1f}, p99 {:.1f} ms (one alone: {:.1f}, {:.1f})\n",
      many, (crowded - alone) / many, alone, crowded, all["fewest_a_second"].get<double>(),
      all["age_p50_ms"].get<double>(), all["age_p99_ms"].get<double>(), one["age_p50_ms"].get<double>(),
      one["age_p99_ms"].get<double>());
}

void one_stopped(const Options& options, FakeHouse& house) {
  const double seconds = options.small ? 9 : 65;
  const auto before = watched(options, house, 10, options.small ? 3 : 20).second;
  const std::uint64_t stalled = house.counters().sessions_stalled.value();
  const Viewers bad(options.program, house, {"--viewers", "1", "--seconds", "1000"});
  bad.stop();
  const auto after = watched(options, house, 10, seconds).second;
  fmt::print("one viewer stopped for {:.0f} s: the others' p99 age {:.1f} ms, {:.1f} before; {} dropped\n",
             seconds, after["age_p99_ms"].get<double>(), before["age_p99_ms"].get<double>(),
             house.counters().sessions_stalled.value() - stalled);
  // What it was sent before its buffers were full takes its time: small pictures may fit for a while.
  if (!options.small)
    require(house.counters().sessions_stalled.value() == stalled + 1, "the stopped viewer is dropped");
}

void idle_sockets(const Options& options, FakeHouse& house) {
  const int idle = options.small ? 100 : 1000;
  const double seconds = options.small ? 3 : 30;
  const auto before = watched(options, house, 10, options.small ? 3 : 20).second;
  const double before_mb = resident_mb();
  Viewers bad(options.program, house,
              {"--viewers", "0", "--idle", std::to_string(idle), "--seconds", std::to_string(seconds + 2)});
  const auto after = watched(options, house, 10, seconds).second;
  const double after_mb = resident_mb();
  fmt::print(
      "{} idle sockets: the viewers' p99 age {:.1f} ms, {:.1f} before; memory {:.1f} MB, {:.1f} before; {} "
      "opened in all\n",
      idle, after["age_p99_ms"].get<double>(), before["age_p99_ms"].get<double>(), after_mb, before_mb,
      bad.report()["idle_opened"].get<int>());
}

/// slowhttptest's slow headers, slow bodies and slow reads, a thousand connections each.
void slow_attacks(const Options& options, FakeHouse& house) {
  const char* const kProgram = "/usr/bin/slowhttptest";
  if (options.small) return;
  if (access(kProgram, X_OK) != 0) {
    fmt::print("slowhttptest is not installed, and so not run\n");
    return;
  }
  const auto before = watched(options, house, 10, 20).second;
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  const std::string url = fmt::format("http://127.0.0.1:{}/", house.endpoint().port());
  for (const char* const kind : {"-H", "-B", "-X"}) {
    const double before_mb = resident_mb();
    const pid_t attack =
        spawned({kProgram, kind, "-c", "1000", "-r", "200", "-l", "25", "-i", "2", "-u", url}, nowhere);
    const auto meanwhile = watched(options, house, 10, 20).second;
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
  FakeHouse house(StreamServer::Config{});
  const Show show(house);
  many_viewers(options, house);
  one_stopped(options, house);
  idle_sockets(options, house);
  slow_attacks(options, house);
  const ServerCounters& counts = house.counters();
  const std::uint64_t done = counts.pictures_sent.value() + counts.pictures_skipped.value();
  fmt::print("{} pictures offered, {} sent, {} skipped\n", counts.pictures_offered.value(),
             counts.pictures_sent.value(), counts.pictures_skipped.value());
  require(counts.pictures_offered.value() >= done && counts.pictures_offered.value() <= done + 4,
          "every offered picture is counted");
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
