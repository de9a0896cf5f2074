// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <ctime>
#include <optional>
#include <string>

#include "proto/dicom/identity.hpp"

namespace fanlight {

/// A series for the pictures and clips of one call or one session.
struct DicomSeries {
  DicomIdentity identity;                    ///< with a study_uid
  std::optional<std::time_t> study_began{};  ///< absent: only the scanner knows, whose order it is
  std::string series_uid;
  std::uint32_t next_instance = 1;

  /// A new series of the identity's study; a new study where the identity has none.
  static DicomSeries begin(DicomIdentity identity);
};

}  // namespace fanlight
