// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/still_request.hpp"

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

Error wrong(std::string sentence) {
  return {ErrorCode::kInvalidArgument, std::move(sentence)};
}

/// RFC 4648, section 4.
Result<std::vector<std::uint8_t>> decode_base64(const std::string& text) {
  constexpr std::size_t kCharacters = 4;  // for three bytes
  std::vector<std::uint8_t> bytes(text.size() / kCharacters * 3);
  const auto* from = reinterpret_cast<const unsigned char*>(text.data());
  const bool decoded =
      !text.empty() && text.size() % kCharacters == 0 &&
      EVP_DecodeBlock(bytes.data(), from, static_cast<int>(text.size())) == static_cast<int>(bytes.size());
  if (!decoded) return wrong("png is not in base64, expected a PNG file in base64");
  bytes.resize(bytes.size() - static_cast<std::size_t>(std::min<std::ptrdiff_t>(
                                  2, std::count(text.end() - kCharacters, text.end(), '='))));
  return bytes;
}

}  // namespace

Result<StillRequest> parse_still_request(std::string_view body) {
  const auto json = nlohmann::json::parse(body, nullptr, false);
  const bool has_both = json.is_object() && json.size() == 2 && json.contains("patient") &&
                        json.contains("png") && json["png"].is_string();
  if (!has_both) return wrong(R"(expected {"png": PICTURE IN BASE64, "patient": {"patient_id": ID}})");
  auto patient = parse_identity(json["patient"]);
  if (!patient) return patient.error();
  if (patient->patient_id.empty() && patient->patient_name.empty())
    return wrong("the patient has neither an ID nor a name, expected one of them");
  const auto file = decode_base64(json["png"].get_ref<const std::string&>());
  if (!file) return file.error();
  auto picture = read_png(*file);
  if (!picture) return picture.error();
  return StillRequest{.patient = *std::move(patient), .picture = *std::move(picture)};
}

}  // namespace fanlight
