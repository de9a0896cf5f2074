// SPDX-License-Identifier: Apache-2.0
#include "acquisition/open_source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/base/nearest_name.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kPhantom = "phantom:";
constexpr std::string_view kReplay = "replay:";
constexpr std::string_view kUsb = "usb:";
constexpr std::string_view kIgtl = "igtl:";

PhantomSource::Pace phantom_pace(SourcePace pace) {
  switch (pace) {
    case SourcePace::kRealTime:
      return PhantomSource::Pace::kRealTime;
    case SourcePace::kPatient:
      return PhantomSource::Pace::kPatient;
    case SourcePace::kAsFastAsTaken:
      return PhantomSource::Pace::kUnpaced;
  }
  return PhantomSource::Pace::kRealTime;
}

Result<std::unique_ptr<FrameSource>> open_phantom(std::string_view text, const SourceOptions& options) {
  PhantomSource::Config config = usual_phantom();
  config.pace = phantom_pace(options.pace);
  auto parsed = parse_phantom(text, config);
  if (!parsed) return parsed.error();
  if (options.ends_whole && parsed->volumes > 0 && parsed->pace == PhantomSource::Pace::kRealTime)
    parsed->pace = PhantomSource::Pace::kPatient;
  auto source = PhantomSource::create(*parsed);
  if (!source) return source.error();
  return std::unique_ptr<FrameSource>(*std::move(source));
}

Result<std::unique_ptr<FrameSource>> open_recording(std::string_view path, const SourceOptions& options,
                                                    ReplayLink* link) {
  auto source = ReplaySource::create({.recording = {.path = path, .geometry_path = options.geometry_path},
                                      .pace = options.pace == SourcePace::kAsFastAsTaken
                                                  ? ReplaySource::Pace::kAsFastAsTaken
                                                  : ReplaySource::Pace::kRecorded,
                                      .speed = options.speed,
                                      .ending = options.ending,
                                      .from_s = options.from_s,
                                      .paused = options.paused,
                                      .link = link});
  if (!source) return source.error();
  return std::unique_ptr<FrameSource>(*std::move(source));
}

Result<std::unique_ptr<FrameSource>> open_probe(std::string_view address, const SourceOptions& options,
                                                ProbeLink& link) {
  const auto parsed = UsbAddress::parse(address);
  if (!parsed) return parsed.error();
  auto source = UsbSource::create(
      {.address = *parsed, .settings = options.probe_settings, .wait_s = options.wait_for_probe_s}, link);
  if (!source) return source.error();
  return std::unique_ptr<FrameSource>(*std::move(source));
}

Result<std::unique_ptr<FrameSource>> open_igtl(std::string_view address, const SourceOptions& options,
                                               ProbeLink& link) {
  const auto parsed = IgtlAddress::parse(address);
  if (!parsed) return parsed.error();
  auto source = IgtlSource::create({.address = *parsed,
                                    .geometry_path = options.geometry_path,
                                    .wait_s = options.wait_for_probe_s,
                                    .stopped = options.stopped},
                                   link);
  if (!source) return source.error();
  return std::unique_ptr<FrameSource>(*std::move(source));
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_source(std::string_view text, const SourceOptions& options,
                                                 ProbeLink& probe, ReplayLink* replay) {
  if (text.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "the source is empty, expected phantom:, replay:PATH, usb:VENDOR:PRODUCT or igtl:HOST"};
  }
  if (text.starts_with(kUsb)) return open_probe(text.substr(kUsb.size()), options, probe);
  if (text.starts_with(kIgtl)) return open_igtl(text.substr(kIgtl.size()), options, probe);
  if (text.starts_with(kPhantom)) return open_phantom(text.substr(kPhantom.size()), options);
  if (text.starts_with(kReplay)) {
    text.remove_prefix(kReplay.size());
  } else if (std::error_code unknown; !std::filesystem::exists(text, unknown)) {
    const std::size_t colon = text.find(':');
    const std::string kind(text.substr(0, colon == std::string_view::npos ? colon : colon + 1));
    if (const std::string meant = nearest_name(kind, {"phantom:", "replay:", "usb:", "igtl:"});
        !meant.empty()) {
      return Error{ErrorCode::kNotFound,
                   fmt::format("there is no source {}, did you mean {}?", in_quotes(text), meant)};
    }
  }
  return open_recording(text, options, replay);
}

}  // namespace fanlight
