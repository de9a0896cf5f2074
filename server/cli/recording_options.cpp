// SPDX-License-Identifier: Apache-2.0
#include "server/cli/recording_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "proto/base/printable.hpp"
#include "server/cli/named_option.hpp"

namespace fanlight {

void RecordingOptions::add_to(CLI::App& command) {
  auto* const needed =
      command
          .add_option("--recordings", folder, "Folder for recordings; displays may then start and stop one")
          ->type_name("FOLDER");
  add_named_option<PixelForm, PixelForm>(command, "--recording-form", form,
                                         {{"raw", PixelForm::kRaw}, {"zlib", PixelForm::kZlib}},
                                         "Format of the pixels: raw (the default) or zlib")
      ->needs(needed);
  command.add_option("--recording-minutes", most_minutes, "Maximum length of a recording; 0: no limit")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e5))
      ->needs(needed)
      ->type_name("MIN");
  command
      .add_option("--recording-last", last_minutes,
                  "Always keep the last minutes on disk, for the button \"Keep\"; 0: no")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e4))
      ->needs(needed)
      ->type_name("MIN");
  command.add_flag("--recording-at-start", at_start, "Start a recording at once")->needs(needed);
}

RecordingProxy::Config RecordingOptions::config() const {
  return {.folder = folder,
          .form = form,
          .most_s = 60 * most_minutes,
          .last_s = 60 * last_minutes,
          .at_start = at_start};
}

Result<void> RecordingOptions::make_folder() const {
  if (folder.empty()) return {};
  std::error_code failure;
  if (std::filesystem::create_directories(folder, failure) && !failure) {
    // Recordings show patients.
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all, failure);
    spdlog::info("created the folder {} for recordings", printable(folder.string()));
  }
  if (!failure && access(folder.c_str(), W_OK | X_OK) == 0) return {};
  const std::string why = failure ? failure.message() : std::generic_category().message(errno);
  return Error{
      ErrorCode::kUnavailable,
      fmt::format("--recordings {} cannot be written ({}), expected a folder that this user may write",
                  printable(folder.string()), why)};
}

}  // namespace fanlight
