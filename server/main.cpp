// SPDX-License-Identifier: Apache-2.0
#include <spdlog/cfg/env.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <new>
#include <vector>

#include "server/cli/commands.hpp"

namespace {

constexpr int kUsageError = 2;

int run(int argc, char** argv) {
  CLI::App program("Fanlight renders the surface in 4D ultrasound and streams it to displays.", "fanlight");
  program.set_version_flag("--version", FANLIGHT_VERSION);
  program.require_subcommand(1);
  const std::vector<std::pair<std::string, fanlight::Command>> commands = {
      {"serve", fanlight::add_serve_command(program)}, {"render", fanlight::add_render_command(program)},
      {"watch", fanlight::add_watch_command(program)}, {"token", fanlight::add_token_command(program)},
      {"audit", fanlight::add_audit_command(program)}, {"bench", fanlight::add_bench_command(program)},
      {"info", fanlight::add_info_command(program)}};
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : kUsageError;
  }
  for (const auto& [name, command] : commands) {
    if (!program.got_subcommand(name)) continue;
    if (const auto done = command(); !done) {
      std::fprintf(stderr, "fanlight %s: %s\n", name.c_str(), done.error().message.c_str());
      return 1;
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    spdlog::cfg::load_env_levels();  // SPDLOG_LEVEL=warn: messages of this level and above
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr,
                 "fanlight: there is not enough memory for this source, expected smaller or fewer volumes\n");
    return 1;
  } catch (const std::exception& error) {
    // Thrown by a library where no caller expected it.
    std::fprintf(stderr, "fanlight: %s\n", error.what());
    return 1;
  }
}
