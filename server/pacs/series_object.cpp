// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/series_object.hpp"

#include <dcmtk/dcmdata/dcostrmb.h>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>

#include "proto/base/printable.hpp"
#include "proto/base/version.hpp"

namespace fanlight {

namespace {

std::string date_text(std::time_t time) {
  return fmt::format("{:%Y%m%d}", fmt::gmtime(time));
}

std::string time_text(std::time_t time) {
  return fmt::format("{:%H%M%S}", fmt::gmtime(time));
}

/// In UTC.
void add_times(DicomFields& fields, const std::optional<std::time_t>& study_began) {
  const std::time_t now = std::time(nullptr);
  fields.text(DCM_TimezoneOffsetFromUTC, "+0000");
  fields.text(DCM_StudyDate, study_began ? date_text(*study_began) : "");
  fields.text(DCM_StudyTime, study_began ? time_text(*study_began) : "");
  fields.text(DCM_ContentDate, date_text(now));
  fields.text(DCM_ContentTime, time_text(now));
}

}  // namespace

DicomSeries DicomSeries::begin(DicomIdentity identity) {
  std::optional<std::time_t> study_began;
  if (identity.study_uid.empty()) {
    identity.study_uid = new_dicom_uid(SITE_STUDY_UID_ROOT);
    study_began = std::time(nullptr);
  }
  return {.identity = std::move(identity),
          .study_began = study_began,
          .series_uid = new_dicom_uid(SITE_SERIES_UID_ROOT)};
}

void begin_object(DicomFields& fields, const char* sop_class, DicomSeries& series) {
  fields.text(DCM_SOPClassUID, sop_class);
  fields.text(DCM_SOPInstanceUID, new_dicom_uid(SITE_INSTANCE_UID_ROOT));
  add_identity(fields, series.identity);
  add_times(fields, series.study_began);
  fields.text(DCM_Modality, "US");
  fields.text(DCM_SeriesInstanceUID, series.series_uid);
  fields.text(DCM_SeriesNumber, "1");
  fields.text(DCM_SeriesDescription, "Fanlight 3D pictures, not for diagnosis");
  fields.text(DCM_InstanceNumber, fmt::format("{}", series.next_instance));
  fields.empty(DCM_Laterality);
  fields.empty(DCM_PatientOrientation);
  fields.text(DCM_Manufacturer, "Fanlight");
  fields.text(DCM_ManufacturerModelName, "Fanlight");
  fields.text(DCM_SoftwareVersions, version());
  fields.text(DCM_ImageType, "DERIVED\\SECONDARY");
  fields.text(DCM_DerivationDescription, "Surface of an ultrasound volume, rendered by Fanlight");
  fields.text(DCM_ImageComments, "Not for diagnosis");
  fields.text(DCM_BurnedInAnnotation, "YES");
  fields.text(DCM_RecognizableVisualFeatures, "YES");  // it may show a face
  ++series.next_instance;
}

Result<std::vector<std::uint8_t>> object_bytes(DcmFileFormat& file, bool failed, E_TransferSyntax syntax,
                                               std::size_t pixel_bytes) {
  if (failed) {
    return Error{ErrorCode::kUnavailable,
                 "the DICOM object cannot be made, expected free memory and DICOM's dictionary"};
  }
  constexpr std::size_t kMostHeadBytes = std::size_t{1} << 16;
  std::vector<std::uint8_t> bytes(pixel_bytes + kMostHeadBytes);
  DcmOutputBufferStream stream(bytes.data(), static_cast<offile_off_t>(bytes.size()));
  file.transferInit();
  const OFCondition written = file.write(stream, syntax, EET_ExplicitLength, nullptr);
  file.transferEnd();
  if (written.bad()) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("the DICOM object cannot be made ({}), expected free memory", printable(written.text()))};
  }
  void* start = nullptr;
  offile_off_t size = 0;
  stream.flushBuffer(start, size);
  bytes.resize(static_cast<std::size_t>(size));
  return bytes;
}

}  // namespace fanlight
