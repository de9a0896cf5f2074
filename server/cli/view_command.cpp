// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/cli/commands.hpp"

namespace fanlight {

namespace {

constexpr const char* kProgram = "fanlight-view";

}  // namespace

Result<void> run_native_display(const std::vector<std::string>& given) {
  std::vector<std::string> words = {kProgram};
  words.insert(words.end(), given.begin(), given.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::error_code failure;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", failure);
  // The one next to this program belongs to the same version.
  if (!failure) execv((self.parent_path() / kProgram).c_str(), arguments.data());
  execvp(kProgram, arguments.data());
  return Error{
      ErrorCode::kNotFound,
      fmt::format("{} is not installed, expected it in the folder of fanlight or in the PATH", kProgram)};
}

Command add_view_command(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("view", "Show the picture in a window or full screen (more: --help)");
  command->set_help_flag();  // --help is the other program's
  command->prefix_command();
  return [command] { return run_native_display(command->remaining()); };
}

}  // namespace fanlight
