// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/identity_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

/// A field of the identity, and what DICOM allows in it (PS3.5, table 6.2-1).
struct Row {
  std::string_view name;
  std::string DicomIdentity::*member;
  std::size_t most_characters;
  bool (*allows)(std::string_view);
  std::string_view expected;
};

/// Characters of UTF-8, not bytes.
std::size_t characters_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

bool is_text(std::string_view text) {
  return is_printable(text) && text.find('\\') == std::string_view::npos;
}

/// Groups for letters, ideographs and sounds, of at most 64 characters each (PS3.5, 6.2, VR PN).
bool is_name(std::string_view text) {
  constexpr std::size_t kMostGroups = 3;
  constexpr std::size_t kMostInGroup = 64;
  std::string_view rest = text;
  for (std::size_t groups = 1;; ++groups) {
    const std::size_t end = rest.find('=');
    if (groups > kMostGroups || characters_of(rest.substr(0, end)) > kMostInGroup) return false;
    if (end == std::string_view::npos) return is_text(text);
    rest.remove_prefix(end + 1);
  }
}

bool is_date(std::string_view text) {
  if (text.size() != 8 || !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; }))
    return false;
  const auto number = [text](std::size_t at, std::size_t digits) {
    int value = 0;
    for (const char digit : text.substr(at, digits)) value = 10 * value + (digit - '0');
    return value;
  };
  return std::chrono::year_month_day(std::chrono::year(number(0, 4)),
                                     std::chrono::month(static_cast<unsigned>(number(4, 2))),
                                     std::chrono::day(static_cast<unsigned>(number(6, 2))))
      .ok();
}

bool is_sex(std::string_view text) {
  return text == "M" || text == "F" || text == "O";
}

bool is_uid(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
}

constexpr std::string_view kText = "text without control characters and backslashes";
constexpr std::string_view kName = "up to three groups of 64 characters, without backslashes";
constexpr std::size_t kMostInName = 194;

constexpr std::array kRows = {
    Row{"patient_name", &DicomIdentity::patient_name, kMostInName, is_name, kName},
    Row{"patient_id", &DicomIdentity::patient_id, 64, is_text, kText},
    Row{"issuer_of_patient_id", &DicomIdentity::issuer_of_patient_id, 64, is_text, kText},
    Row{"birth_date", &DicomIdentity::birth_date, 8, is_date, "a day as YYYYMMDD"},
    Row{"sex", &DicomIdentity::sex, 1, is_sex, "M, F or O"},
    Row{"accession_number", &DicomIdentity::accession_number, 16, is_text, kText},
    Row{"study_uid", &DicomIdentity::study_uid, 64, is_uid, "digits and dots"},
    Row{"study_id", &DicomIdentity::study_id, 16, is_text, kText},
    Row{"study_description", &DicomIdentity::study_description, 64, is_text, kText},
    Row{"referring_physician", &DicomIdentity::referring_physician, kMostInName, is_name, kName},
    Row{"requested_procedure_id", &DicomIdentity::requested_procedure_id, 16, is_text, kText},
    Row{"scheduled_step_id", &DicomIdentity::scheduled_step_id, 16, is_text, kText},
};

Error wrong_identity(std::string_view sentence) {
  return {ErrorCode::kInvalidArgument, fmt::format("the identity of the patient: {}", sentence)};
}

Result<void> check_field(const Row& row, std::string_view text) {
  if (text.empty()) return {};
  if (!row.allows(text))
    return wrong_identity(fmt::format("{} is not as DICOM wants it, expected {}", row.name, row.expected));
  if (characters_of(text) > row.most_characters)
    return wrong_identity(
        fmt::format("{} is too long, expected at most {} characters", row.name, row.most_characters));
  return {};
}

/// Else it may be a patient's name in the wrong place, which must not be repeated.
bool looks_like_a_field(std::string_view name) {
  constexpr std::size_t kMost = 40;
  return !name.empty() && name.size() <= kMost &&
         std::ranges::all_of(name, [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
}

Result<void> take_field(const std::string& name, const nlohmann::json& value, DicomIdentity& identity) {
  const auto row = std::ranges::find(kRows, name, &Row::name);
  if (row == kRows.end()) {
    std::array<std::string_view, kRows.size()> names;
    std::ranges::transform(kRows, names.begin(), &Row::name);
    return wrong_identity(fmt::format("{} no field of it, expected {}",
                                      looks_like_a_field(name) ? name + " is" : "one of the names is",
                                      fmt::join(names, ", ")));
  }
  if (!value.is_string())
    return wrong_identity(fmt::format("{} is no text, expected {}", name, row->expected));
  const auto& text = value.get_ref<const std::string&>();
  identity.*row->member = text;
  return check_field(*row, text);
}

}  // namespace

nlohmann::json identity_json(const DicomIdentity& identity) {
  nlohmann::json json = nlohmann::json::object();
  for (const Row& row : kRows) {
    if (const std::string& value = identity.*row.member; !value.empty()) json[std::string(row.name)] = value;
  }
  return json;
}

Result<void> check_identity(const DicomIdentity& identity) {
  for (const Row& row : kRows) {
    if (auto field = check_field(row, identity.*row.member); !field) return field;
  }
  return {};
}

Result<DicomIdentity> parse_identity(const nlohmann::json& json) {
  if (!json.is_object())
    return wrong_identity("it is no JSON object, expected one, such as {\"patient_id\": \"P123\"}");
  DicomIdentity identity;
  for (const auto& [name, value] : json.items()) {
    if (auto taken = take_field(name, value, identity); !taken) return taken.error();
  }
  return identity;
}

Result<DicomIdentity> read_identity(const std::filesystem::path& path) {
  constexpr std::size_t kMostBytes = 65'536;
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.empty())
    return Error{ErrorCode::kNotFound, fmt::format("{} cannot be read, expected a JSON file with the patient",
                                                   printable(path.string()))};
  if (text.size() > kMostBytes)
    return wrong_identity(fmt::format("the file is larger than {} bytes", kMostBytes));
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_discarded()) return wrong_identity("the file is not JSON, expected an object");
  return parse_identity(json);
}

}  // namespace fanlight
