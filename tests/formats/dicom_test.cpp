// SPDX-License-Identifier: Apache-2.0
// DICOM files as recordings, and volumes as DICOM files. `dicom_check` beside this file asks an independent
// checker about what is written.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "acquisition/convert/dicom_volume.hpp"
#include "acquisition/replay/file_facts.hpp"
#include "acquisition/replay/recording.hpp"
#include "tests/support/dicom_file.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr const char* kGeometry =
    "pixel_width_mm = 0.5\npixel_height_mm = 0.5\nface_column = 3.5\nface_row = 0\nmotor_radius_mm = 28\n"
    "first_angle_deg = -10\nlast_angle_deg = 10\n";

class DicomTest : public testing::Test {
 protected:
  Result<OpenedSequence> open() const { return open_recording_file(path_, std::uint64_t{1} << 30); }
  Result<Recording> record() const { return Recording::open({.path = path_, .geometry_path = {}}); }
  std::string refusal() const {
    const auto opened = open();
    return opened ? "" : opened.error().message;
  }
  std::vector<std::uint8_t> frame(std::uint64_t number) const {
    auto opened = open();
    if (!opened) return {};
    std::vector<std::uint8_t> pixels(opened->sequence.frame_bytes());
    return opened->pixels.read(number, pixels) ? pixels : std::vector<std::uint8_t>();
  }

  /// The functional groups of each frame of the file, read into `file`.
  DcmSequenceOfItems* frames_of(DcmFileFormat& file) const {
    EXPECT_TRUE(file.loadFile(path_.c_str()).good());
    file.loadAllDataIntoMemory();  // it is saved in the place of itself
    DcmSequenceOfItems* frames = nullptr;
    EXPECT_TRUE(file.getDataset()->findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, frames).good());
    return frames;
  }

  static std::vector<std::uint8_t> ramp(std::size_t values) {
    std::vector<std::uint8_t> pixels(values);
    for (std::size_t i = 0; i < values; ++i) pixels[i] = static_cast<std::uint8_t>(i * 7);
    return pixels;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "x.dcm";
};

TEST_F(DicomTest, PlaysTheCalibratedRegionOfAMultiFrameImage) {
  DicomImage image(5);
  image.pixels(ramp(std::size_t{5} * 16 * 12));
  image.region({0, 0, 15, 11}, {0.03, 0.03}, 2);  // colour flow: not the tissue
  image.region({2, 3, 12, 10}, {0.031, 0.032});
  image.save(path_);
  write_file(folder_ / "x.dcm.toml", kGeometry);
  const auto recording = record();
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().columns, 11U);
  EXPECT_EQ(recording->summary().rows, 8U);
  EXPECT_NEAR(recording->summary().frame_rate_hz, 20, 1e-9);
  EXPECT_NE(recording->summary().notes.at(0).find("from column 2 and row 3 on"), std::string::npos);
  const auto whole = ramp(std::size_t{5} * 16 * 12);
  for (std::size_t row = 0; row < 8; ++row)
    EXPECT_EQ(recording->frame_pixels(4)[row * 11 + 4], whole[4 * 192 + (row + 3) * 16 + 6]) << row;
  const auto opened = open();
  EXPECT_NEAR(opened->sequence.pixel_size->width_mm, 0.31, 1e-9);
  EXPECT_NEAR(opened->sequence.pixel_size->height_mm, 0.32, 1e-9);
  for (const std::string& note : recording->summary().notes)
    EXPECT_EQ(note.find("SECRET"), std::string::npos) << "nothing about the patient is reported";
}

TEST_F(DicomTest, ANegativeSizeOfPixelsIsNamed) {
  DicomImage image(5);
  image.pixels(ramp(std::size_t{5} * 16 * 12));
  image.region({2, 3, 12, 10}, {0.031, -0.032});
  image.save(path_);
  write_file(folder_ / "x.dcm.toml", kGeometry);
  const auto recording = record();
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_TRUE(std::ranges::any_of(recording->summary().notes, [](const std::string& note) {
    return note.find("PhysicalDeltaY, is negative") != std::string::npos;
  }));
  EXPECT_NEAR(open()->sequence.pixel_size->height_mm, 0.32, 1e-9);
}

TEST_F(DicomTest, LacksWhatNoFieldTells) {
  DicomImage image(5);
  image.pixels(ramp(std::size_t{5} * 16 * 12));
  image.save(path_);
  EXPECT_NE(record().error().message.find("the fan geometry lacks"), std::string::npos)
      << record().error().message;
  const auto facts = look_into(path_, 1 << 20);
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->with_time, 5U);
  EXPECT_EQ(facts->with_angle, 0U);
}

TEST_F(DicomTest, ReadsEachWayToStorePixels) {
  const auto grey = ramp(std::size_t{3} * 16 * 12);
  for (const E_TransferSyntax syntax :
       {EXS_LittleEndianExplicit, EXS_LittleEndianImplicit, EXS_BigEndianExplicit, EXS_RLELossless,
        EXS_JPEGProcess14SV1, EXS_JPEGLSLossless}) {
    DicomImage image(3);
    image.pixels(grey);
    image.save(path_, syntax);
    for (const std::uint64_t number : {2, 0, 1}) {
      const auto pixels = frame(number);
      ASSERT_EQ(pixels.size(), 192U) << syntax << ": " << refusal();
      EXPECT_TRUE(std::ranges::equal(pixels, std::span(grey).subspan(number * 192, 192))) << syntax;
    }
  }
}

TEST_F(DicomTest, ReadsColourAsLuminance) {
  DicomImage image(2);
  std::vector<std::uint8_t> colours;
  for (int i = 0; i < 2 * 192; ++i) colours.insert(colours.end(), {200, 100, static_cast<std::uint8_t>(i)});
  image.set_samples(3, 8, 8);
  image.text(DCM_PhotometricInterpretation, "RGB");
  image.pixels(colours);
  image.save(path_);
  EXPECT_EQ(frame(0).at(50), std::lround(0.299 * 200 + 0.587 * 100 + 0.114 * 50));

  image.text(DCM_PhotometricInterpretation, "YBR_FULL");
  image.save(path_);
  EXPECT_EQ(frame(0).at(50), 200);

  std::vector<std::uint8_t> halved;  // Y Y Cb Cr
  for (int i = 0; i < 192; ++i)
    halved.insert(halved.end(),
                  {static_cast<std::uint8_t>(2 * i), static_cast<std::uint8_t>(2 * i + 1), 9, 9});
  image.text(DCM_PhotometricInterpretation, "YBR_FULL_422");
  image.pixels(halved);
  image.save(path_);
  for (const std::size_t pixel : {0, 1, 50, 191}) EXPECT_EQ(frame(0).at(pixel), pixel % 256);
  EXPECT_EQ(frame(1).at(5), 197);
}

TEST_F(DicomTest, ReadsTwelveSignedBitsAndInvertedGrey) {
  DicomImage image(2);
  image.set_samples(1, 16, 12, true);
  std::vector<std::uint16_t> values(2 * 192);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<std::uint16_t>((i * 10 + 0xF00) & 0xFFF);
  image.pixels(values);
  image.save(path_);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_TRUE(opened->sequence.format.is_signed);
  const auto stored = opened->pixels.stored_values();
  ASSERT_TRUE(stored);
  const auto* const signed_values = reinterpret_cast<const std::int16_t*>(stored->data());
  EXPECT_EQ(signed_values[0], -256);
  EXPECT_EQ(signed_values[30], 44);

  DicomImage inverted(2);
  inverted.text(DCM_PhotometricInterpretation, "MONOCHROME1");
  inverted.pixels(ramp(2 * 192));
  inverted.save(path_);
  EXPECT_EQ(frame(0).at(3), 255 - 21);
}

TEST_F(DicomTest, IsRefusedInOneSentence) {
  const auto changed = [&](auto change, const char* expected,
                           E_TransferSyntax syntax = EXS_LittleEndianExplicit) {
    DicomImage image(3);
    image.pixels(ramp(3 * 192));
    change(image);
    image.save(path_, syntax);
    EXPECT_NE(refusal().find(expected), std::string::npos) << refusal();
    EXPECT_NE(refusal().find("expected"), std::string::npos);
  };
  changed([](DicomImage& image) { image.text(DCM_SOPClassUID, UID_CTImageStorage); },
          "this DICOM file is CTImageStorage");
  changed([](DicomImage& image) { image.text(DCM_SOPClassUID, "1.2.3"); }, "1.2.3");
  changed([](DicomImage& image) { image.text(DCM_PhotometricInterpretation, "PALETTE COLOR"); },
          "PALETTE COLOR");
  changed([](DicomImage& image) { image.whole(DCM_Columns, 0); }, "0 x 12 pixels");
  changed([](DicomImage& image) { image.whole(DCM_BitsAllocated, 32); }, "of 32 bits");
  changed([](DicomImage& image) { image.text(DCM_NumberOfFrames, "-4"); }, "-4 frames");
  changed([](DicomImage& image) { image.text(DCM_NumberOfFrames, "2000000000"); }, "2000000000 frames");
  changed([](DicomImage& image) { delete image.dataset().remove(DCM_PixelData); }, "no pixels");
  changed([](DicomImage&) {}, "deflated", EXS_DeflatedLittleEndianExplicit);
  std::string bytes(132, '\0');
  bytes.replace(128, 4, "DICM");
  write_file(path_, bytes);
  EXPECT_NE(refusal().find("expected"), std::string::npos) << refusal();
}

TEST_F(DicomTest, RefusesFramesThatAreNotThere) {
  DicomImage image(3);
  image.pixels(ramp(2 * 192));
  image.save(path_);
  EXPECT_NE(refusal().find("its pixels do not match the 3 frames"), std::string::npos) << refusal();
  image.pixels(ramp(3 * 192));
  image.save(path_, EXS_RLELossless);
  DcmFileFormat file;
  ASSERT_TRUE(file.loadFile(path_.c_str()).good());
  file.loadAllDataIntoMemory();
  ASSERT_TRUE(file.getDataset()->putAndInsertString(DCM_NumberOfFrames, "900000").good());
  ASSERT_TRUE(file.saveFile(path_.c_str(), EXS_RLELossless).good());
  EXPECT_NE(refusal().find("its pixels do not match the 900000 frames"), std::string::npos) << refusal();
}

std::string element(std::uint16_t group, std::uint16_t number, std::string_view type,
                    std::string_view value) {
  std::string bytes = {static_cast<char>(group), static_cast<char>(group >> 8), static_cast<char>(number),
                       static_cast<char>(number >> 8)};
  bytes += type;
  return bytes + static_cast<char>(value.size()) + '\0' + std::string(value);
}

/// DCMTK calls itself for each of them, until the stack is full.
TEST_F(DicomTest, RefusesSequencesThatAreTooDeep) {
  using namespace std::string_literals;
  const std::string begin = std::string(128, '\0') + "DICM";
  const std::string undefined(4, '\xFF');
  const std::string item = "\xFE\xFF\x00\xE0"s + undefined;
  const std::string sequence = "\x18\x00\x11\x60"s;
  const std::string no_type = sequence + undefined + item;
  struct Form {
    std::string syntax;
    std::string first;
    std::string level;
  };
  const Form forms[] = {
      {"1.2.840.10008.1.2.1\0"s, "", sequence + "SQ\0\0"s + undefined + item},
      {"1.2.840.10008.1.2.1\0"s, sequence + "UN\0\0"s + undefined + item, no_type},
      {"1.2.840.10008.1.2\0"s, "", no_type},
  };
  for (const auto& [syntax, first, level] : forms) {
    std::string bytes = begin + element(2, 0x10, "UI", syntax) + first;
    for (int i = 0; i < 100'000; ++i) bytes += level;
    write_file(path_, bytes);
    EXPECT_NE(refusal().find("over 64 deep"), std::string::npos) << refusal();
  }
  // What DCMTK reads in another way than one might think: each is refused at once.
  const std::string deep = [&] {
    std::string bytes;
    for (int i = 0; i < 100'000; ++i) bytes += sequence + "SQ\0\0"s + undefined + item;
    return bytes;
  }();
  const auto long_length = [](std::size_t bytes) {
    return std::string{static_cast<char>(bytes), static_cast<char>(bytes >> 8),
                       static_cast<char>(bytes >> 16), static_cast<char>(bytes >> 24)};
  };
  const std::string ended = "\xFE\xFF\xDD\xE0\0\0\0\0"s + deep;
  const std::string pixel_data = "\xE0\x7F\x10\x00"s;
  for (const std::string& trap :
       {sequence + "SQ\0\0"s + long_length(ended.size()) + ended,
        pixel_data + "SQ\0\0"s + undefined + item + deep, pixel_data + "UN\0\0"s + undefined + item + deep,
        sequence + "QQ\0\0"s + long_length(8) + deep, pixel_data + "OB\0\0"s + undefined + item + deep}) {
    write_file(path_, begin + element(2, 0x10, "UI", "1.2.840.10008.1.2.1\0"s) + trap);
    EXPECT_NE(refusal().find("at byte"), std::string::npos) << refusal();
  }
  for (const std::string& deflated : {"1.2.840.10008.1.2.1.99  "s, "1.2.840.10008.1.2.1.99\0"s}) {
    write_file(path_, begin + element(2, 0x10, "UI", deflated) + deep);
    EXPECT_NE(refusal().find("deflated"), std::string::npos) << refusal();
  }
  write_file(path_, begin + element(2, 0x10, "UI", "1.2.840.10008.1.2.1.99"s) +
                        element(2, 0x10, "UI", "1.2.840.10008.1.2.1\0"s) + deep);
  EXPECT_NE(refusal().find("at byte"), std::string::npos) << "a second transfer syntax: " << refusal();
  // Lengths that are given, from the inside out.
  std::string inside;
  for (int i = 0; i < 2000; ++i) {
    const auto length = [](std::size_t bytes) {
      return std::string{static_cast<char>(bytes), static_cast<char>(bytes >> 8),
                         static_cast<char>(bytes >> 16), '\0'};
    };
    inside = "\xFE\xFF\x00\xE0"s + length(inside.size()) + inside;
    inside = sequence + "SQ\0\0"s + length(inside.size()) + inside;
  }
  write_file(path_, begin + element(2, 0x10, "UI", "1.2.840.10008.1.2.1\0"s) + inside);
  EXPECT_NE(refusal().find("over 64 deep"), std::string::npos) << refusal();
  write_file(path_, begin + element(2, 0x10, "UI", "1.2.3.4") + inside);
  EXPECT_NE(refusal().find("its transfer syntax is \"1.2.3.4\""), std::string::npos) << refusal();
}

GridVolume ramps(std::uint32_t slices) {
  GridVolume grid{.origin_mm = {-7, 2, -12}, .spacing_mm = 0.5, .size = {20, 30, slices}};
  for (std::uint32_t k = 0; k < slices; ++k) {
    for (std::uint32_t j = 0; j < 30; ++j) {
      for (std::uint32_t i = 0; i < 20; ++i)
        grid.voxels.push_back(static_cast<std::uint8_t>(10 + i + 2 * j + k));
    }
  }
  return grid;
}

TEST_F(DicomTest, AVolumeComesBackAsItWasWritten) {
  const GridVolume grid = ramps(40);
  const auto written = write_grid_dicom(path_, grid, {.geometry = {.probe_radius_mm = 40}});
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(std::filesystem::status(path_).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_EQ(write_grid_dicom(path_, grid, {}).error().code, ErrorCode::kInvalidArgument)
      << "the name is taken";
  const auto recording = record();
  ASSERT_TRUE(recording) << recording.error().message;
  const FanGeometry& geometry = recording->summary().geometry;
  EXPECT_EQ(geometry.columns, 20U);
  EXPECT_NEAR(geometry.plane_point({7, 0}).x_mm, -7 + 3.5, 1e-9) << "where the grid lay below the probe";
  int compared = 0;
  for (std::size_t frame = 0; frame < recording->frames().size(); ++frame) {
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      const Point at = geometry.point(0, {.angle_rad = recording->frames()[frame].angle_rad,
                                          .depth_mm = geometry.plane_point({0, 1.0 * row}).depth_mm});
      const double j = (at.y_mm - 2) / 0.5;
      const double k = (at.z_mm + 12) / 0.5;
      if (j < 0 || j > 29 || k < 0 || k > 39) continue;
      ASSERT_NEAR(recording->frame_pixels(frame)[row * 20 + 7], 10 + 7 + 2 * j + k, 0.51);
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST_F(DicomTest, SaysWhatItWasTakenWith) {
  const auto code = [&](const FanGeometry& geometry, const DcmTagKey& sequence) {
    std::filesystem::remove(path_);
    EXPECT_TRUE(write_grid_dicom(path_, ramps(3), {.geometry = geometry, .acquired_utc_s = 86'400}));
    DcmFileFormat file;
    EXPECT_TRUE(file.loadFile(path_.c_str()).good());
    DcmItem* item = nullptr;
    OFString meaning;
    if (file.getDataset()->findAndGetSequenceItem(sequence, item, 0).good())
      item->findAndGetOFString(DCM_CodeMeaning, meaning);
    OFString acquired;
    file.getDataset()->findAndGetOFString(DCM_AcquisitionDateTime, acquired);
    EXPECT_EQ(acquired, "19700102000000");
    return std::string(meaning.c_str());
  };
  EXPECT_EQ(code({.probe_radius_mm = 40}, DCM_TransducerGeometryCodeSequence),
            "Curved linear ultrasound transducer geometry");
  EXPECT_EQ(code({.motor_radius_mm = 30}, DCM_TransducerGeometryCodeSequence),
            "Linear ultrasound transducer geometry");
  EXPECT_EQ(code({}, DCM_TransducerBeamSteeringCodeSequence), "Mechanical beam steering");
  EXPECT_EQ(code({}, DCM_TransducerScanPatternCodeSequence), "Volume scan pattern");
}

TEST_F(DicomTest, RefusesPlanesThatAreNoRectangles) {
  const double orientations[][6] = {{1, 0, 0, 0.8, 0.6, 0}, {10, 0, 0, 0, 10, 0}, {1, 0, 0, 0, 0, 0}};
  for (const auto& orientation : orientations) {
    std::filesystem::remove(path_);
    ASSERT_TRUE(write_grid_dicom(path_, ramps(5), {}));
    DcmFileFormat file;
    ASSERT_TRUE(file.loadFile(path_.c_str()).good());
    file.loadAllDataIntoMemory();
    DcmItem* shared = nullptr;
    DcmItem* item = nullptr;
    ASSERT_TRUE(
        file.getDataset()->findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, shared, 0).good());
    ASSERT_TRUE(shared->findAndGetSequenceItem(DCM_PlaneOrientationVolumeSequence, item, 0).good());
    ASSERT_TRUE(item->putAndInsertFloat64Array(DCM_ImageOrientationVolume, orientation, 6).good());
    ASSERT_TRUE(file.saveFile(path_.c_str(), EXS_LittleEndianExplicit).good());
    EXPECT_NE(refusal().find("at right angles"), std::string::npos) << refusal();
  }
}

TEST_F(DicomTest, TakesTimesFromAVector) {
  DicomImage image(4);
  image.pixels(ramp(4 * 192));
  image.text(DCM_FrameTimeVector, "0\\50\\ 40.5 \\60");
  image.save(path_);
  const auto times = open();
  ASSERT_TRUE(times) << times.error().message;
  EXPECT_NEAR(*times->sequence.frames[3].timestamp_s, 0.1505, 1e-9);
  image.text(DCM_FrameTimeVector, "0\\50");  // too few: the even Frame Time counts
  image.save(path_);
  EXPECT_NEAR(*open()->sequence.frames[3].timestamp_s, 0.15, 1e-9);
}

/// Planes of a motor's sweep, as a scanner may store them that does not scan convert.
TEST_F(DicomTest, FitsAFanToPlanesThatTurn) {
  ASSERT_TRUE(write_grid_dicom(path_, ramps(21), {.geometry = {.probe_radius_mm = 40}}));
  DcmFileFormat file;
  DcmSequenceOfItems* const frames = frames_of(file);
  ASSERT_NE(frames, nullptr);
  constexpr double kRadiusMm = 28;
  for (unsigned long i = 0; i < 21; ++i) {
    const double angle_rad = radians(2.0 * static_cast<double>(i) - 20);
    DcmItem* item = nullptr;
    ASSERT_TRUE(
        frames->getItem(i)->findOrCreateSequenceItem(DCM_PlanePositionVolumeSequence, item, 0).good());
    const double position[] = {-5, kRadiusMm * std::cos(angle_rad) - kRadiusMm,
                               kRadiusMm * std::sin(angle_rad)};
    ASSERT_TRUE(item->putAndInsertFloat64Array(DCM_ImagePositionVolume, position, 3).good());
    ASSERT_TRUE(
        frames->getItem(i)->findOrCreateSequenceItem(DCM_PlaneOrientationVolumeSequence, item, 0).good());
    const double orientation[] = {1, 0, 0, 0, std::cos(angle_rad), std::sin(angle_rad)};
    ASSERT_TRUE(item->putAndInsertFloat64Array(DCM_ImageOrientationVolume, orientation, 6).good());
  }
  ASSERT_TRUE(file.saveFile(path_.c_str(), EXS_LittleEndianExplicit).good());
  write_file(folder_ / "x.dcm.toml", "face_column = 9.5\nface_row = 0\n");
  const auto recording = record();
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_NEAR(recording->summary().geometry.motor_radius_mm, kRadiusMm, 0.01);
  EXPECT_NEAR(recording->summary().largest_angle_deg, 20, 0.01);
  EXPECT_NEAR(recording->summary().geometry.pixel_width_mm, 0.5, 1e-6);
}

TEST_F(DicomTest, GivesAllVolumesWithTheirTimes) {
  ASSERT_TRUE(write_grid_dicom(path_, ramps(20), {}));
  DcmFileFormat file;
  DcmSequenceOfItems* const frames = frames_of(file);
  ASSERT_NE(frames, nullptr);
  for (unsigned long i = 0; i < 20; ++i) {
    // The slices of two volumes, in turn: the order in the file is free.
    DcmItem* item = nullptr;
    ASSERT_TRUE(frames->getItem(i)->findOrCreateSequenceItem(DCM_TemporalPositionSequence, item, 0).good());
    ASSERT_TRUE(item->putAndInsertFloat64(DCM_TemporalPositionTimeOffset, i % 2 == 0 ? 0.0 : 0.25).good());
    ASSERT_TRUE(
        frames->getItem(i)->findOrCreateSequenceItem(DCM_PlanePositionVolumeSequence, item, 0).good());
    const double position[] = {0, 0, -2 + static_cast<double>(i / 2)};
    ASSERT_TRUE(item->putAndInsertFloat64Array(DCM_ImagePositionVolume, position, 3).good());
  }
  ASSERT_TRUE(file.saveFile(path_.c_str(), EXS_LittleEndianExplicit).good());
  const auto recording = record();
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().sweeps, 2U);
  const auto second = recording->sweeps()[1].first_frame;
  EXPECT_NEAR(static_cast<double>(recording->frames()[second].time_ns) * 1e-9, 0.25, 1e-9);
  EXPECT_NEAR(recording->frame_pixels(second)[7], recording->frame_pixels(0)[7] + 1, 0.51);
}

}  // namespace
}  // namespace fanlight::test
