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

/// `begins_study`: else the study is that of an order, and began when only the scanner knows.
void add_times(DicomFields& fields, bool begins_study) {
  const auto now = fmt::gmtime(std::time(nullptr));
  const std::string date = fmt::format("{:%Y%m%d}", now);
  const std::string time = fmt::format("{:%H%M%S}", now);
  fields.text(DCM_TimezoneOffsetFromUTC, "+0000");
  fields.text(DCM_StudyDate, begins_study ? date : "");
  fields.text(DCM_StudyTime, begins_study ? time : "");
  fields.text(DCM_ContentDate, date);
  fields.text(DCM_ContentTime, time);
}

}  // namespace

DicomSeries DicomSeries::begin(DicomIdentity identity) {
  const bool begins_study = identity.study_uid.empty();
  if (begins_study) identity.study_uid = new_dicom_uid(SITE_STUDY_UID_ROOT);
  return {.identity = std::move(identity),
          .begins_study = begins_study,
          .series_uid = new_dicom_uid(SITE_SERIES_UID_ROOT)};
}

void begin_object(DicomFields& fields, const char* sop_class, DicomSeries& series) {
  fields.text(DCM_SOPClassUID, sop_class);
  fields.text(DCM_SOPInstanceUID, new_dicom_uid(SITE_INSTANCE_UID_ROOT));
  add_identity(fields, series.identity);
  add_times(fields, series.begins_study);
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
