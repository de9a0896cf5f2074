// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "proto/dicom/identity.hpp"

namespace fanlight {

/// The known fields, by the names of DicomIdentity.
nlohmann::json identity_json(const DicomIdentity& identity);

/// kInvalidArgument: a field has what DICOM cannot hold. The sentence names the field and never its value.
Result<void> check_identity(const DicomIdentity& identity);

/// Reads an object with some of these fields. Other names are refused, and so is what DICOM cannot hold.
/// kInvalidArgument; the sentence names the field and never its value.
Result<DicomIdentity> parse_identity(const nlohmann::json& json);

/// Reads a file of such an object, of at most 64 KB. kNotFound, kInvalidArgument.
Result<DicomIdentity> read_identity(const std::filesystem::path& path);

}  // namespace fanlight
