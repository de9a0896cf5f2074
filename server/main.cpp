// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/cfg/env.h>
#include <CLI/CLI.hpp>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "proto/base/version.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/log_format.hpp"
#include "server/help/command_help.hpp"
#include "server/help/option_table.hpp"
#include "server/help/usage_sentence.hpp"

namespace {

constexpr int kUsageError = 2;

/// The exit code of a command that succeeded. What it printed is in memory until now; on a full disk it would
/// be lost without a word.
int flush_output() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  fanlight::print_error("fanlight", "what was to be printed could not be written, expected room for it");
  return 1;
}

/// One sentence about a command line or a configuration that is not understood.
int usage_error(const CLI::App& program, const CLI::ParseError& error) {
  const fanlight::UsageError wrong = fanlight::usage_error(program, error);
  fanlight::print_error(wrong.command, wrong.sentence);
  return kUsageError;
}

int run(int argc, char** argv) {
  CLI::App program("Fanlight renders the surface in 4D ultrasound and streams it to displays.", "fanlight");
  program.set_version_flag("-V,--version", fanlight::version(), "Print the version and exit");
  program.require_subcommand(1);
  const std::vector<std::pair<std::string, fanlight::Command>> commands = {
      {"serve", fanlight::add_serve_command(program)},
      {"render", fanlight::add_render_command(program)},
      {"export", fanlight::add_export_command(program)},
      {"batch", fanlight::add_batch_command(program)},
      {"watch", fanlight::add_watch_command(program)},
      {"view", fanlight::add_view_command(program)},
      {"token", fanlight::add_token_command(program)},
      {"audit", fanlight::add_audit_command(program)},
      {"bench", fanlight::add_bench_command(program)},
      {"info", fanlight::add_info_command(program)},
      {"record", fanlight::add_record_command(program)},
      {"recover", fanlight::add_recover_command(program)},
      {"convert", fanlight::add_convert_command(program)},
      {"send", fanlight::add_send_command(program)},
      {"worklist", fanlight::add_worklist_command(program)},
      {"help", fanlight::add_help_command(program)},
      {"version", fanlight::add_version_command(program)},
      {"man", fanlight::add_man_command(program)},
      {"completion", fanlight::add_completion_command(program)}};
  fanlight::use_command_help(program);
  if (argc < 2) {
    fmt::print("{}", fanlight::command_help(program, false));
    return flush_output();
  }
  // CLI11 would only say that a command is required.
  if (const auto lacks = fanlight::lacking_command(program, {argv + 1, argv + argc}); !lacks.empty()) {
    fanlight::print_error("fanlight", lacks);
    return kUsageError;
  }
  try {
    program.parse(argc, argv);
    for (const auto& [name, command] : commands) {
      if (!program.got_subcommand(name)) continue;
      if (const auto done = command(); !done) {
        fanlight::print_error("fanlight " + name, done.error().message);
        return done.error().code == fanlight::ErrorCode::kInvalidArgument ? kUsageError : 1;
      }
    }
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error) == 0 ? flush_output() : kUsageError;
    return usage_error(program, error);
  }
  return flush_output();
}

/// An exception that nothing catches: one sentence, and the end, instead of an abort. A lack of threads or
/// memory is the system's state; whatever else it is, it is an error of the program, whose state is kept.
[[noreturn]] void end_for_lack_of_resources() {
  try {
    std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    std::fputs("fanlight: out of memory, exiting\n", stderr);
    std::_Exit(1);
  } catch (const std::system_error& error) {
    std::fprintf(stderr, "fanlight: the system refused a thread or a lock (%s), exiting\n", error.what());
    std::_Exit(1);
  } catch (...) {
    std::abort();
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::set_terminate(end_for_lack_of_resources);
  // Beyond a limit for the size of files, a write then fails, which is an error to report.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    spdlog::cfg::load_env_levels();  // SPDLOG_LEVEL=warn: messages of this level and above
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr,
                 "fanlight: there is not enough memory for this source, expected smaller or fewer volumes\n");
    return 1;
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return flush_output();
    // Thrown by a library where no caller expected it.
    fanlight::print_error("fanlight", error.what());
    return 1;
  }
}
