#pragma once

#include <CLI/App.hpp>
#include <functional>

#include "proto/result.hpp"

namespace fanlight {

/// What a subcommand does once its options are read; an Error's sentence goes to stderr.
using Command = std::function<Result<void>()>;

// Each adds a subcommand with its options to the program and returns what it does.
Command add_serve_command(CLI::App& program);
Command add_render_command(CLI::App& program);
Command add_info_command(CLI::App& program);
Command add_bench_command(CLI::App& program);
Command add_watch_command(CLI::App& program);
Command add_token_command(CLI::App& program);
Command add_audit_command(CLI::App& program);

}  // namespace fanlight
