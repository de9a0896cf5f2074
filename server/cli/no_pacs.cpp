// SPDX-License-Identifier: Apache-2.0
// In place of send_command.cpp, worklist_command.cpp and server/pacs/still_queue.cpp in a build without
// DCMTK.
#include <CLI/CLI.hpp>

#include "server/cli/commands.hpp"
#include "server/pacs/still_queue.hpp"

namespace fanlight {

namespace {

Error missing() {
  return {ErrorCode::kUnsupported,
          "this program was built without DCMTK, expected one built with FANLIGHT_DICOM=ON"};
}

Command add_missing(CLI::App& program, const char* name, const char* description) {
  program.add_subcommand(name, description)->allow_extras();
  return [] { return Result<void>(missing()); };
}

}  // namespace

Command add_send_command(CLI::App& program) {
  return add_missing(program, "send",
                     "Send pictures and volumes to a DICOM archive (PACS); not in this build");
}

Command add_worklist_command(CLI::App& program) {
  return add_missing(program, "worklist", "List scheduled examinations; not in this build");
}

Result<std::unique_ptr<StillArchive>> open_still_queue(const std::filesystem::path& /*folder*/,
                                                       StillQueue::Post /*post*/) {
  return missing();
}

}  // namespace fanlight
