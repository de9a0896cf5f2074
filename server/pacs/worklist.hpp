// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/dicom/identity.hpp"
#include "server/pacs/dicom_peer.hpp"

namespace fanlight {

/// What to look for in a worklist. An empty text matches all.
struct WorklistQuery {
  std::string date;              ///< of the scheduled step: YYYYMMDD, or a range of two with a hyphen
  std::string station_title;     ///< of the scanner for which the step is scheduled
  std::string modality = "US";   ///< of the scheduled step
  std::string patient_id;        ///< wildcards * and ?
  std::string accession_number;  ///< wildcards * and ?
};

/// A scheduled examination. Its texts are UTF-8 and as the peer has them: printable() is for screens.
struct WorklistEntry {
  DicomIdentity identity;
  std::string date;  ///< YYYYMMDD
  std::string time;  ///< HHMMSS
  std::string step_description;
  std::string station_title;
  bool has_unknown_characters = false;  ///< it is in a character set that is not known; texts are not UTF-8
};

/// Asks a modality worklist (C-FIND, PS3.4 K), and returns at most 500 entries, in the order of their dates
/// and times. Texts of any character set of DICOM become UTF-8. Errors: as of Association::open(); kBadInput:
/// more entries, or the peer reports a failure.
Result<std::vector<WorklistEntry>> find_worklist(const DicomPeer& peer, const WorklistQuery& query);

}  // namespace fanlight
