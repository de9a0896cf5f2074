// SPDX-License-Identifier: Apache-2.0
#include "server/state/measurement_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "proto/base/owned_file.hpp"
#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

// Above what MeasurementStore takes: 4 MB of regions in base64, and its points.
constexpr off_t kMostFileBytes = 20'000'000;

Error unreadable(const std::string& why) {
  return {ErrorCode::kUnavailable,
          fmt::format("it cannot be read ({}), expected a regular file of at most 20 MB", why)};
}

std::string shortened(std::string_view text) {
  constexpr std::size_t kMostBytes = 120;
  return printable(text.substr(0, text.find('\n')).substr(0, kMostBytes));
}

}  // namespace

Result<std::optional<std::string>> read_measurement_file(const std::filesystem::path& path) {
  const OwnedFile file(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  if (!file.is_open() && errno == ENOENT) return std::optional<std::string>();
  if (!file.is_open()) return unreadable(std::generic_category().message(errno));
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) return unreadable(std::generic_category().message(errno));
  if (!S_ISREG(facts.st_mode)) return unreadable("it is no regular file");
  if (facts.st_size > kMostFileBytes) return unreadable(fmt::format("it has {} bytes", facts.st_size));
  std::string text(static_cast<std::size_t>(facts.st_size), '\0');
  std::size_t got = 0;
  while (got < text.size()) {
    const ssize_t part = read(file.get(), text.data() + got, text.size() - got);
    if (part < 0 && errno == EINTR) continue;
    if (part < 0) return unreadable(std::generic_category().message(errno));
    if (part == 0) break;
    got += static_cast<std::size_t>(part);
  }
  text.resize(got);
  return std::optional(std::move(text));
}

ReadMeasurements parse_measurements(std::string_view text) {
  ReadMeasurements read;
  const auto whole = nlohmann::json::parse(text, nullptr, false);
  if (!whole.is_object() || !whole.contains("measurements") || !whole["measurements"].is_array()) {
    read.troubles.emplace_back("it has no list of measurements");
    return read;
  }
  if (const auto bytes = whole.find("recording_bytes"); bytes != whole.end()) {
    // 64 bit are a text in protobuf's JSON.
    v1::MeasurementFile facts;
    const std::string only = nlohmann::json{{"recording_bytes", *bytes}}.dump();
    if (google::protobuf::util::JsonStringToMessage(only, &facts).ok())
      read.file.set_recording_bytes(facts.recording_bytes());
  }
  for (const auto& entry : whole["measurements"]) {
    v1::Measurement measurement;
    const std::string one = entry.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (const auto parsed = google::protobuf::util::JsonStringToMessage(one, &measurement); !parsed.ok()) {
      read.troubles.push_back("an entry cannot be read: " +
                              shortened({parsed.message().data(), parsed.message().size()}));
    } else {
      *read.file.add_measurements() = std::move(measurement);
    }
  }
  return read;
}

std::string measurement_file_text(const v1::MeasurementFile& file) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string text;
  (void)google::protobuf::util::MessageToJsonString(file, &text, options);
  return text;
}

}  // namespace fanlight
