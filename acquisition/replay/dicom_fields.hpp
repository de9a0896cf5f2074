// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcdeftag.h>
#include <dcmtk/dcmdata/dcitem.h>
#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight::dicom {

inline Error bad(const std::string& name, std::string_view wrong, std::string_view expected,
                 ErrorCode code = ErrorCode::kBadInput) {
  return {code, fmt::format("{}: {}, expected {}", name, wrong, expected)};
}

/// The first value of a field; empty where there is none.
inline std::string text_of(DcmItem& item, const DcmTagKey& key) {
  OFString text;
  return item.findAndGetOFString(key, text).good() ? std::string(text.c_str()) : std::string();
}

/// A field of type US; `otherwise` where there is none.
inline std::uint32_t whole_of(DcmItem& item, const DcmTagKey& key, std::uint32_t otherwise) {
  Uint16 value = 0;
  return item.findAndGetUint16(key, value).good() ? value : otherwise;
}

}  // namespace fanlight::dicom
