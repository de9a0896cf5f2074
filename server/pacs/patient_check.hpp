// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/base/result.hpp"
#include "proto/dicom/identity.hpp"

namespace fanlight {

/// Compares a DICOM file with the patient and the study that a call is for: name, ID and study UID, as far as
/// `identity` has them. kInvalidArgument: another one, or none; the sentence names the field and never its
/// value. kBadInput: it is not DICOM.
Result<void> check_same_patient(const std::filesystem::path& path, const DicomIdentity& identity);

}  // namespace fanlight
