// SPDX-License-Identifier: Apache-2.0
#include "server/cli/recording_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
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
  command
      .add_option("--recordings-reserve", reserve_mb,
                  "Free space that recordings leave on the disk; recording waits while there is less "
                  "(default: 1000, or 5 "
                  "% of the disk where that is less)")
      ->check(CLI::Range(0.0, 1e9))
      ->needs(needed)
      ->type_name("MB");
  command
      .add_option(
          "--recordings-quota", quota_mb,
          "Space that the files in the folder may take; recording waits while they take more; 0: no limit")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e9))
      ->needs(needed)
      ->type_name("MB");
  command.add_flag("--recording-at-start", at_start, "Start a recording at once")->needs(needed);
}

RecordingProxy::Config RecordingOptions::config() const {
  return {.folder = folder,
          .form = form,
          .most_s = 60 * most_minutes,
          .last_s = 60 * last_minutes,
          .at_start = at_start};
}

Recorder::Config RecordingOptions::recorder() const {
  constexpr double kUsualReserveMb = 1000;
  constexpr double kShareOfDisk = 0.05;
  std::error_code unknown;
  const auto disk = std::filesystem::space(folder, unknown);
  const double share_mb = unknown ? kUsualReserveMb : kShareOfDisk * static_cast<double>(disk.capacity) / 1e6;
  const auto bytes = [](double mb) { return static_cast<std::uint64_t>(mb * 1e6); };
  return {.folder = folder,
          .form = form,
          .reserve_bytes = bytes(reserve_mb.value_or(std::min(kUsualReserveMb, share_mb))),
          .quota_bytes = bytes(quota_mb)};
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
