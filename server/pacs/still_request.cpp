// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/still_request.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "server/pacs/identity_json.hpp"

namespace fanlight {

namespace {

Error wrong_request(std::string sentence) {
  return {ErrorCode::kInvalidArgument, std::move(sentence)};
}

/// RFC 4648, section 4.
Result<std::vector<std::uint8_t>> decode_base64(const std::string& text, std::string_view name) {
  constexpr std::size_t kCharacters = 4;  // for three bytes
  std::vector<std::uint8_t> bytes(text.size() / kCharacters * 3);
  const auto* from = reinterpret_cast<const unsigned char*>(text.data());
  const bool decoded =
      !text.empty() && text.size() % kCharacters == 0 &&
      EVP_DecodeBlock(bytes.data(), from, static_cast<int>(text.size())) == static_cast<int>(bytes.size());
  if (!decoded)
    return wrong_request(
        fmt::format("{} is not in base64, expected a picture file in base64 without line breaks", name));
  bytes.resize(bytes.size() - static_cast<std::size_t>(std::min<std::ptrdiff_t>(
                                  2, std::count(text.end() - kCharacters, text.end(), '='))));
  return bytes;
}

bool is_blank(std::string_view text) {
  return text.find_first_not_of(" ^=") == std::string_view::npos;
}

Result<void> take_loss(const nlohmann::json& json, StillRequest& still) {
  const auto method = json.is_object() ? json.value("method", nlohmann::json()) : nlohmann::json();
  const auto ratio = json.is_object() ? json.value("ratio", nlohmann::json()) : nlohmann::json();
  const bool is_known = method == "jpeg" || method == "h264";
  constexpr double kMostRatio = 100'000;  // DICOM keeps it in 16 characters
  const double value = ratio.is_number() ? ratio.get<double>() : 0;
  if (!is_known || value < 1 || value > kMostRatio || json.size() != 2)
    return wrong_request(
        R"(lossy is of another form, expected {"method": "jpeg" or "h264", "ratio": 1 to 100000})");
  still.lossy_method = method == "jpeg" ? "ISO_10918_1" : "ISO_14496_10";
  still.lossy_ratio = value;
  return {};
}

Result<void> take_clip(const nlohmann::json& json, ClipRequest& clip) {
  constexpr double kMostRate = 60;
  const auto rate = json.value("pictures_per_second", nlohmann::json());
  clip.pictures_per_second = rate.is_number() ? rate.get<double>() : 0;
  if (!(clip.pictures_per_second >= 0.1 && clip.pictures_per_second <= kMostRate))
    return wrong_request("pictures_per_second is no rate, expected 0.1 to 60");
  for (const auto& jpeg : json["jpegs"]) {
    auto file = jpeg.is_string() ? decode_base64(jpeg.get_ref<const std::string&>(), "jpegs")
                                 : Result<std::vector<std::uint8_t>>(wrong_request(
                                       "jpegs has something else than texts, expected files in base64"));
    if (!file) return file.error();
    clip.jpegs.push_back(*std::move(file));
  }
  return {};
}

/// A parser would take forty times the memory of a body that is nested at each character, or has an element
/// at each.
bool is_flat(std::string_view json) {
  constexpr int kMostDepth = 2;
  constexpr int kMostCommas = 1000;
  int commas = 0;
  int depth = 0;
  bool in_text = false;
  for (std::size_t at = 0; at < json.size() && depth <= kMostDepth; ++at) {
    const char c = json[at];
    if (in_text && c == '\\') {
      ++at;
    } else if (c == '"') {
      in_text = !in_text;
    } else if (!in_text && (c == '{' || c == '[')) {
      ++depth;
    } else if (!in_text && (c == '}' || c == ']')) {
      --depth;
    } else if (!in_text && c == ',' && ++commas > kMostCommas) {
      return false;
    }
  }
  return depth <= kMostDepth;
}

Result<DicomIdentity> take_patient(const nlohmann::json& json) {
  auto patient = parse_identity(json);
  if (patient && is_blank(patient->patient_id) && is_blank(patient->patient_name))
    return wrong_request("the patient has neither an ID nor a name, expected one of them");
  return patient;
}

}  // namespace

Result<DicomIdentity> parse_volume_request(std::string_view body) {
  const auto json = is_flat(body) ? nlohmann::json::parse(body, nullptr, false) : nlohmann::json();
  if (!json.is_object() || json.size() != 2 || !json.contains("patient") || !json.contains("volume"))
    return wrong_request(R"(expected {"volume": "shown", "patient": {"patient_id": ID}})");
  return take_patient(json["patient"]);
}

Result<PictureRequest> parse_picture_request(std::string_view body) {
  const auto json = is_flat(body) ? nlohmann::json::parse(body, nullptr, false) : nlohmann::json();
  const bool has_patient = json.is_object() && json.contains("patient");
  const bool is_lossy = json.is_object() && json.contains("lossy");
  const bool is_clip = has_patient && json.contains("jpegs") && json["jpegs"].is_array();
  const bool is_still = has_patient && json.contains("png") && json["png"].is_string();
  if (!(is_clip && json.size() == 3) && !(is_still && json.size() == (is_lossy ? 3 : 2)))
    return wrong_request(
        R"(expected {"png": PICTURE IN BASE64, "patient": {"patient_id": ID}}, or for a clip "jpegs": )"
        R"([PICTURE, ...] and "pictures_per_second": NUMBER in place of "png")");
  auto patient = take_patient(json["patient"]);
  if (!patient) return patient.error();
  if (is_clip) {
    ClipRequest clip{.patient = *std::move(patient)};
    if (auto taken = take_clip(json, clip); !taken) return taken.error();
    return PictureRequest(std::move(clip));
  }
  const auto file = decode_base64(json["png"].get_ref<const std::string&>(), "png");
  if (!file) return file.error();
  auto picture = read_png(*file);
  if (!picture) return picture.error();
  StillRequest still{.patient = *std::move(patient), .picture = *std::move(picture)};
  if (is_lossy) {
    if (auto taken = take_loss(json["lossy"], still); !taken) return taken.error();
  }
  return PictureRequest(std::move(still));
}

}  // namespace fanlight
