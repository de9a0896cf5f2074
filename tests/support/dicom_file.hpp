// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcrleerg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djencode.h>
#include <dcmtk/dcmjpeg/djrplol.h>
#include <dcmtk/dcmjpls/djencode.h>
#include <dcmtk/dcmjpls/djrparam.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace fanlight::test {

/// Builds an ultrasound multi-frame image. It is valid unless a test changes it. Needs DCMTK.
class DicomImage {
 public:
  explicit DicomImage(std::uint32_t frames, std::uint32_t columns = 16, std::uint32_t rows = 12) {
    text(DCM_SOPClassUID, UID_UltrasoundMultiframeImageStorage);
    text(DCM_SOPInstanceUID, "1.2.3.4");
    text(DCM_PhotometricInterpretation, "MONOCHROME2");
    text(DCM_NumberOfFrames, std::to_string(frames));
    text(DCM_PatientName, "SECRET^NAME");
    text(DCM_FrameTime, "50");
    whole(DCM_Columns, columns);
    whole(DCM_Rows, rows);
    set_samples(1, 8, 8);
  }

  DcmDataset& dataset() { return *file_.getDataset(); }
  void text(const DcmTagKey& key, const std::string& value) {
    ASSERT_TRUE(dataset().putAndInsertString(key, value.c_str()).good());
  }
  void whole(const DcmTagKey& key, std::uint32_t value) {
    ASSERT_TRUE(dataset().putAndInsertUint16(key, static_cast<Uint16>(value)).good());
  }
  void set_samples(std::uint32_t samples, std::uint32_t allocated_bits, std::uint32_t stored_bits,
                   bool is_signed = false) {
    whole(DCM_SamplesPerPixel, samples);
    if (samples > 1) whole(DCM_PlanarConfiguration, 0);
    whole(DCM_BitsAllocated, allocated_bits);
    whole(DCM_BitsStored, stored_bits);
    whole(DCM_HighBit, stored_bits - 1);
    whole(DCM_PixelRepresentation, is_signed ? 1 : 0);
  }
  void pixels(const std::vector<std::uint8_t>& values) {
    ASSERT_TRUE(dataset().putAndInsertUint8Array(DCM_PixelData, values.data(), values.size()).good());
  }
  void pixels(const std::vector<std::uint16_t>& values) {
    ASSERT_TRUE(dataset().putAndInsertUint16Array(DCM_PixelData, values.data(), values.size()).good());
  }

  /// A region of 2D tissue, from (left, top) to (right, bottom), its pixels `size_cm` wide and high.
  void region(std::array<std::uint32_t, 4> bounds, std::array<double, 2> size_cm,
              std::uint32_t data_type = 1) {
    DcmItem* item = nullptr;
    constexpr signed long kNew = -2;
    ASSERT_TRUE(dataset().findOrCreateSequenceItem(DCM_SequenceOfUltrasoundRegions, item, kNew).good());
    item->putAndInsertUint16(DCM_RegionSpatialFormat, 1);
    item->putAndInsertUint16(DCM_RegionDataType, static_cast<Uint16>(data_type));
    item->putAndInsertUint16(DCM_PhysicalUnitsXDirection, 3);
    item->putAndInsertUint16(DCM_PhysicalUnitsYDirection, 3);
    const DcmTagKey keys[] = {DCM_RegionLocationMinX0, DCM_RegionLocationMinY0, DCM_RegionLocationMaxX1,
                              DCM_RegionLocationMaxY1};
    for (std::size_t i = 0; i < 4; ++i) {
      const Uint32 bound = bounds[i];
      item->putAndInsertUint32Array(keys[i], &bound, 1);
    }
    item->putAndInsertFloat64(DCM_PhysicalDeltaX, size_cm[0]);
    item->putAndInsertFloat64(DCM_PhysicalDeltaY, size_cm[1]);
  }

  void save(const std::filesystem::path& path, E_TransferSyntax syntax = EXS_LittleEndianExplicit) {
    DcmRLEEncoderRegistration::registerCodecs();
    DJEncoderRegistration::registerCodecs();
    DJLSEncoderRegistration::registerCodecs();
    const DJ_RPLossless lossless;
    const DJLSRepresentationParameter jpeg_ls;
    const DcmRepresentationParameter* how = nullptr;
    if (syntax == EXS_JPEGProcess14SV1) how = &lossless;
    if (syntax == EXS_JPEGLSLossless) how = &jpeg_ls;
    ASSERT_TRUE(dataset().chooseRepresentation(syntax, how).good());
    ASSERT_TRUE(file_.saveFile(path.c_str(), syntax).good());
  }

 private:
  DcmFileFormat file_;
};

}  // namespace fanlight::test
