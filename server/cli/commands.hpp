// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <string>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// Runs a subcommand after its options were parsed. The sentence of an Error is printed to stderr.
using Command = std::function<Result<void>()>;

// Each adds a subcommand with its options to the program, and returns the function that runs it.
Command add_serve_command(CLI::App& program);
Command add_render_command(CLI::App& program);
Command add_export_command(CLI::App& program);
Command add_batch_command(CLI::App& program);
Command add_record_command(CLI::App& program);
Command add_recover_command(CLI::App& program);
Command add_convert_command(CLI::App& program);
Command add_send_command(CLI::App& program);
Command add_worklist_command(CLI::App& program);
Command add_info_command(CLI::App& program);
Command add_bench_command(CLI::App& program);
Command add_watch_command(CLI::App& program);
Command add_view_command(CLI::App& program);
Command add_token_command(CLI::App& program);
Command add_audit_command(CLI::App& program);
// The program must outlive these: they print its commands.
Command add_help_command(CLI::App& program);
Command add_version_command(CLI::App& program);
Command add_man_command(CLI::App& program);
Command add_completion_command(CLI::App& program);

/// Replaces this process by the program of the native display, which is one of its own, so that a server
/// needs no libraries of a desktop. Returns where that is not installed.
Result<void> run_native_display(const std::vector<std::string>& arguments);

}  // namespace fanlight
