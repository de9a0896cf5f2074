// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/base/result.hpp"

namespace fanlight {

/// Whether a file begins as DICOM files do (PS3.10, 7.1), whatever its name. kUnavailable: it cannot be read;
/// the sentence has the system's reason.
Result<bool> is_dicom_file(const std::filesystem::path& path);

}  // namespace fanlight
