// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/patient_check.hpp"

// DCMTK's first header must come first.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "proto/base/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

namespace {

struct Field {
  DcmTagKey key;
  std::string DicomIdentity::*member;
  std::string_view name;
};

}  // namespace

Result<void> check_same_patient(const std::filesystem::path& path, const DicomIdentity& identity) {
  silence_dicom_log();
  DcmFileFormat file;
  if (const OFCondition read = file.loadFile(path.c_str()); read.bad()) {
    return Error{ErrorCode::kBadInput, fmt::format("{} cannot be read ({}), expected DICOM",
                                                   printable(path.string()), printable(read.text()))};
  }
  DcmDataset& dataset = *file.getDataset();
  (void)dataset.convertToUTF8();  // else a name with such letters is another one
  const std::array fields{Field{DCM_PatientID, &DicomIdentity::patient_id, "patient_id"},
                          Field{DCM_PatientName, &DicomIdentity::patient_name, "patient_name"},
                          Field{DCM_StudyInstanceUID, &DicomIdentity::study_uid, "study_uid"}};
  for (const auto& [key, member, name] : fields) {
    const std::string& wanted = identity.*member;
    if (wanted.empty() || dicom_text(dataset, key) == wanted) continue;
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} has another {} than the file of --patient, or none, expected the same: give "
                             "convert that file too",
                             printable(path.string()), name)};
  }
  return {};
}

}  // namespace fanlight
