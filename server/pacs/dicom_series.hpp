// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/dicom/identity.hpp"

namespace fanlight {

/// A series for the pictures and clips of one call or one session.
struct DicomSeries {
  DicomIdentity identity;     ///< with a study_uid
  bool begins_study = false;  ///< the study is new, and begins now
  std::string series_uid;
  std::uint32_t next_instance = 1;

  /// A new series of the identity's study; a new study where the identity has none.
  static DicomSeries begin(DicomIdentity identity);
};

}  // namespace fanlight
