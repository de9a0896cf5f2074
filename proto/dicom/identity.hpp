// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace fanlight {

/// Whose scan it is, and by which order. Texts are UTF-8; an empty one is not known. It is personal data: it
/// goes into DICOM objects only, never into a log, the name of a file or the arguments of a program.
struct DicomIdentity {
  std::string patient_name;  ///< as DICOM writes it: family^given^middle^prefix^suffix
  std::string patient_id;
  std::string issuer_of_patient_id;
  std::string birth_date;  ///< YYYYMMDD
  std::string sex;         ///< M, F or O
  std::string accession_number;
  std::string study_uid;  ///< of the order; where it is empty, a new study is made
  std::string study_id;
  std::string study_description;
  std::string referring_physician;
  std::string requested_procedure_id;
  std::string scheduled_step_id;

  bool operator==(const DicomIdentity&) const = default;
};

}  // namespace fanlight
