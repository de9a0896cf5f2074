// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "proto/base/result.hpp"

namespace fanlight {

/// Walks over the elements of a DICOM file (PS3.5, 7 and A.4), whose first 132 bytes are not looked at,
/// before DCMTK reads it. DCMTK calls itself for each sequence inside another, keeps an object for each
/// element, and unfolds a deflated file whole, so a small file could take all of the stack or the memory.
/// kUnsupported: a deflated file, or a transfer syntax that is not read. kBadInput: elements inside each
/// other over 64 deep, over 400 000 of them, or bytes that are no element. `name`: of the file, for the
/// message.
Result<void> check_dicom_nesting(const std::filesystem::path& path, const std::string& name);

}  // namespace fanlight
