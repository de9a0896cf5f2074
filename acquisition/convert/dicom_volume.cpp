// SPDX-License-Identifier: Apache-2.0
#include "acquisition/convert/dicom_volume.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcostrmb.h>
#include <dcmtk/dcmdata/dcuid.h>
#include <dcmtk/dcmdata/dcwcache.h>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <ctime>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/convert/new_file.hpp"
#include "acquisition/replay/dicom_file.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

namespace {

std::string date_time(std::int64_t utc_s) {
  return fmt::format("{:%Y%m%d%H%M%S}", fmt::gmtime(static_cast<std::time_t>(utc_s)));
}

/// Numbers as DICOM's decimal strings, of 16 characters at most.
std::string decimal(double value) {
  return fmt::format("{:.9g}", value);
}

void add_study(DicomFields& fields, const std::string& now, const std::string& acquired,
               const DicomSource& source) {
  for (const DcmTagKey& key : {DCM_PositionReferenceIndicator, DCM_AcquisitionContextSequence, DCM_Laterality,
                               DCM_PatientOrientation})
    fields.empty(key);
  fields.text(DCM_SeriesInstanceUID, new_dicom_uid(SITE_SERIES_UID_ROOT));
  fields.text(DCM_SeriesNumber, "1");
  fields.text(DCM_SeriesDescription,
              fmt::format("Fanlight volume{}, not for diagnosis", source.is_simulated ? ", simulated" : ""));
  fields.text(DCM_InstanceNumber, "1");
  fields.text(DCM_Modality, "US");
  constexpr std::size_t kDateDigits = 8;
  if (source.study_began_utc_s == 0) {
    for (const DcmTagKey& key : {DCM_StudyDate, DCM_StudyTime}) fields.empty(key);
  } else {
    const std::string began = source.study_began_utc_s ? date_time(*source.study_began_utc_s) : acquired;
    fields.text(DCM_StudyDate, began.substr(0, kDateDigits));
    fields.text(DCM_StudyTime, began.substr(kDateDigits));
  }
  fields.text(DCM_ContentDate, now.substr(0, kDateDigits));
  fields.text(DCM_ContentTime, now.substr(kDateDigits));
  fields.text(DCM_AcquisitionDateTime, acquired);
  fields.text(DCM_Manufacturer, "Fanlight");
  fields.text(DCM_ManufacturerModelName, "Fanlight");
  fields.text(DCM_DeviceSerialNumber, "none");
  fields.text(DCM_SoftwareVersions, "Fanlight");
}

void add_space(DicomFields& fields, const FanGeometry& geometry) {
  fields.text(DCM_FrameOfReferenceUID, new_dicom_uid(SITE_INSTANCE_UID_ROOT));
  fields.text(DCM_VolumeFrameOfReferenceUID, new_dicom_uid(SITE_INSTANCE_UID_ROOT));
  fields.text(DCM_SynchronizationFrameOfReferenceUID, new_dicom_uid(SITE_INSTANCE_UID_ROOT));
  fields.text(DCM_SynchronizationTrigger, "NO TRIGGER");
  fields.text(DCM_AcquisitionTimeSynchronized, "N");
  fields.text(DCM_UltrasoundAcquisitionGeometry, "APEX");
  // Where the lines of a frame meet; of a flat array, where the frames do.
  const double apex_mm = geometry.probe_radius_mm > 0 ? geometry.probe_radius_mm : geometry.motor_radius_mm;
  fields.numbers<3>(DCM_ApexPosition, {0, -apex_mm, 0});
  fields.numbers<16>(DCM_VolumeToTransducerMappingMatrix, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
}

void add_image(DicomFields& fields, const GridVolume& grid, const DicomSource& source) {
  const FanGeometry& geometry = source.geometry;
  fields.text(DCM_ImageType, "ORIGINAL\\PRIMARY\\VOLUME\\NONE");
  fields.whole(DCM_SamplesPerPixel, 1);
  fields.text(DCM_PhotometricInterpretation, "MONOCHROME2");
  fields.text(DCM_NumberOfFrames, fmt::format("{}", grid.size[2]));
  fields.whole(DCM_Rows, grid.size[1]);
  fields.whole(DCM_Columns, grid.size[0]);
  fields.whole(DCM_BitsAllocated, 8);
  fields.whole(DCM_BitsStored, 8);
  fields.whole(DCM_HighBit, 7);
  fields.whole(DCM_PixelRepresentation, 0);
  fields.text(DCM_LossyImageCompression, "00");
  fields.text(DCM_PresentationLUTShape, "IDENTITY");
  fields.text(DCM_RescaleIntercept, "0");
  fields.text(DCM_RescaleSlope, "1");
  fields.text(DCM_BurnedInAnnotation, "NO");
  fields.text(DCM_RecognizableVisualFeatures, "YES");  // a surface shows a face
  fields.text(DCM_PositionMeasuringDeviceUsed, "FREEHAND");
  fields.text(DCM_DepthOfScanField, fmt::format("{:.0f}", geometry.depth_mm()));
  // As DCMTK lists them: dcmtk/dcmsr/codes/dcm.h.
  if (geometry.probe_radius_mm > 0) {
    fields.code(DCM_TransducerGeometryCodeSequence, "125253", "DCM",
                "Curved linear ultrasound transducer geometry");
  } else {
    fields.code(DCM_TransducerGeometryCodeSequence, "125252", "DCM", "Linear ultrasound transducer geometry");
  }
  fields.code(DCM_TransducerBeamSteeringCodeSequence, "125258", "DCM", "Mechanical beam steering");
  fields.code(DCM_TransducerApplicationCodeSequence, "125261", "DCM", "External Transducer");
  for (const DcmTagKey& key : {DCM_AnatomicRegionSequence, DCM_ViewCodeSequence})
    fields.code(key, "261665006", "SCT", "Unknown");
  // The standard wants numbers here, and has none for unknown.
  for (const DcmTagKey& key :
       {DCM_MechanicalIndex, DCM_BoneThermalIndex, DCM_CranialThermalIndex, DCM_SoftTissueThermalIndex})
    fields.text(key, "0");
  for (const DcmTagKey& key : {DCM_AcquisitionDuration, DCM_DepthsOfFocus}) fields.numbers<1>(key, {0});
  fields.text(DCM_ImageComments, fmt::format("{}Not for diagnosis. Mechanical and thermal indices, durations "
                                             "and depths of focus are not known; 0 stands in "
                                             "their place.{}",
                                             source.is_simulated ? "Simulated. " : "",
                                             source.acquired_utc_s > 0
                                                 ? ""
                                                 : " Nor is the time of acquisition: that of the conversion "
                                                   "stands there."));
  fields.code(DCM_TransducerScanPatternCodeSequence, "125242", "DCM", "Volume scan pattern");
}

void add_dimensions(DicomFields& fields) {
  const std::string uid = new_dicom_uid(SITE_INSTANCE_UID_ROOT);
  fields.text(DCM_DimensionOrganizationType, "3D");
  fields.item(DCM_DimensionOrganizationSequence).text(DCM_DimensionOrganizationUID, uid);
  DicomFields index = fields.item(DCM_DimensionIndexSequence);
  index.tag(DCM_DimensionIndexPointer, DCM_ImagePositionVolume);
  index.tag(DCM_FunctionalGroupPointer, DCM_PlanePositionVolumeSequence);
  index.text(DCM_DimensionOrganizationUID, uid);
  index.text(DCM_DimensionDescriptionLabel, "Elevation");
}

void add_groups(DicomFields& fields, const GridVolume& grid, const std::string& date_time) {
  const std::string spacing = decimal(grid.spacing_mm);
  DicomFields shared = fields.item(DCM_SharedFunctionalGroupsSequence);
  DicomFields measures = shared.item(DCM_PixelMeasuresSequence);
  measures.text(DCM_PixelSpacing, spacing + "\\" + spacing);
  measures.text(DCM_SliceThickness, spacing);
  measures.text(DCM_SpacingBetweenSlices, spacing);
  shared.item(DCM_PlaneOrientationVolumeSequence).numbers<6>(DCM_ImageOrientationVolume, {1, 0, 0, 0, 1, 0});
  DicomFields window = shared.item(DCM_FrameVOILUTSequence);
  window.text(DCM_WindowCenter, "128");
  window.text(DCM_WindowWidth, "256");
  window.text(DCM_WindowCenterWidthExplanation, "All grey levels");
  DicomFields type = shared.item(DCM_ImageDataTypeSequence);
  type.text(DCM_DataType, "TISSUE_INTENSITY");
  type.text(DCM_AliasedDataType, "NO");
  DicomFields description = shared.item(DCM_USImageDescriptionSequence);
  description.text(DCM_FrameType, "ORIGINAL\\PRIMARY\\VOLUME\\NONE");
  description.text(DCM_VolumetricProperties, "VOLUME");
  description.text(DCM_VolumeBasedCalculationTechnique, "NONE");
  for (std::uint32_t k = 0; k < grid.size[2]; ++k) {
    DicomFields frame = fields.item(DCM_PerFrameFunctionalGroupsSequence);
    DicomFields content = frame.item(DCM_FrameContentSequence);
    content.text(DCM_FrameReferenceDateTime, date_time);
    content.text(DCM_FrameAcquisitionDateTime, date_time);
    content.numbers<1>(DCM_FrameAcquisitionDuration, {0});
    content.index(DCM_DimensionIndexValues, k + 1);
    frame.item(DCM_PlanePositionVolumeSequence)
        .numbers<3>(DCM_ImagePositionVolume,
                    {grid.origin_mm[0], grid.origin_mm[1], grid.origin_mm[2] + k * grid.spacing_mm});
    frame.item(DCM_TemporalPositionSequence).numbers<1>(DCM_TemporalPositionTimeOffset, {0});
  }
}

using Sink = std::function<Result<void>(std::span<const std::uint8_t> part)>;

/// The file's bytes, in parts.
Result<void> write_dataset(DcmFileFormat& file, const Sink& sink) {
  constexpr std::size_t kPart = std::size_t{1} << 20;
  std::vector<std::uint8_t> part(kPart);
  DcmWriteCache cache;
  file.transferInit();
  for (;;) {
    DcmOutputBufferStream stream(part.data(), static_cast<offile_off_t>(part.size()));
    const OFCondition written =
        file.write(stream, EXS_LittleEndianExplicit, EET_ExplicitLength, &cache, EGL_recalcGL, EPD_noChange);
    if (written.bad() && written != EC_StreamNotifyClient)
      return Error{
          ErrorCode::kUnavailable,
          fmt::format("the DICOM file cannot be made ({}), expected free memory", in_quotes(written.text()))};
    void* bytes = nullptr;
    offile_off_t size = 0;
    stream.flushBuffer(bytes, size);
    if (auto done = sink({static_cast<const std::uint8_t*>(bytes), static_cast<std::size_t>(size)}); !done)
      return done;
    if (written.good()) break;
  }
  file.transferEnd();
  return {};
}

Result<void> fill_file(DcmFileFormat& file, const GridVolume& grid, const DicomSource& source) {
  constexpr std::uint64_t kMostBytes = 0xFFFF'FFFE;  // a value's length has 32 bits
  if (grid.bytes() > kMostBytes) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the volume has {} bytes, expected at most {} in a DICOM file", grid.bytes(),
                             kMostBytes)};
  }
  prepare_dicom_library();
  const std::string now = date_time(std::time(nullptr));
  const std::string acquired = source.acquired_utc_s > 0 ? date_time(source.acquired_utc_s) : now;
  bool failed = false;
  DicomFields fields(*file.getDataset(), failed);
  fields.text(DCM_SOPClassUID, UID_EnhancedUSVolumeStorage);
  fields.text(DCM_SOPInstanceUID, new_dicom_uid(SITE_INSTANCE_UID_ROOT));
  fields.text(DCM_TimezoneOffsetFromUTC, "+0000");
  add_identity(fields, source.identity);
  add_study(fields, now, acquired, source);
  add_space(fields, source.geometry);
  add_image(fields, grid, source);
  add_dimensions(fields);
  add_groups(fields, grid, acquired);
  fields.bytes(DCM_PixelData, grid.voxels);
  if (failed)
    return Error{ErrorCode::kUnavailable,
                 "the DICOM file cannot be made, expected free memory and DICOM's dictionary"};
  return {};
}

}  // namespace

Result<void> write_grid_dicom(const std::filesystem::path& path, const GridVolume& grid,
                              const DicomSource& source) {
  DcmFileFormat file;
  if (auto filled = fill_file(file, grid, source); !filled) return filled;
  NewFile to(path);
  if (auto done = to.create(); !done) return done;
  if (auto done = write_dataset(file, [&to](std::span<const std::uint8_t> part) { return to.write(part); });
      !done)
    return done;
  return to.finish();
}

Result<std::vector<std::uint8_t>> grid_dicom(const GridVolume& grid, const DicomSource& source) {
  DcmFileFormat file;
  if (auto filled = fill_file(file, grid, source); !filled) return filled.error();
  std::vector<std::uint8_t> bytes;
  const auto append = [&bytes](std::span<const std::uint8_t> part) {
    bytes.insert(bytes.end(), part.begin(), part.end());
    return Result<void>();
  };
  if (auto done = write_dataset(file, append); !done) return done.error();
  return bytes;
}

}  // namespace fanlight
