// SPDX-License-Identifier: Apache-2.0
// In place of send_command.cpp and worklist_command.cpp in a build without DCMTK.
#include <CLI/CLI.hpp>

#include "server/cli/commands.hpp"

namespace fanlight {

namespace {

Command add_missing(CLI::App& program, const char* name, const char* description) {
  program.add_subcommand(name, description)->allow_extras();
  return [] {
    return Result<void>(
        Error{ErrorCode::kUnsupported,
              "this program was built without DCMTK, expected one built with FANLIGHT_DICOM=ON"});
  };
}

}  // namespace

Command add_send_command(CLI::App& program) {
  return add_missing(program, "send",
                     "Send pictures and volumes to a DICOM archive (PACS); not in this build");
}

Command add_worklist_command(CLI::App& program) {
  return add_missing(program, "worklist", "List scheduled examinations; not in this build");
}

}  // namespace fanlight
