// SPDX-License-Identifier: Apache-2.0
// Damaged recordings: each damage is refused with a message that says what was expected.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "acquisition/replay/replay_source.hpp"
#include "tests/unit/recording_fixture.hpp"

namespace fanlight {
namespace {

using test::NamedFile;
using test::RecordingTest;
using test::write_file;

TEST_F(RecordingTest, RefusesMoreThanTheLimit) {
  write_file(path_, test::fan_recording(5, 1, 20).bytes());
  const auto refused = Recording::open({.path = path_, .geometry_path = {}, .max_bytes = 5 * 48 - 1});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("expected at most 239 bytes of pixels"), std::string::npos);
}

TEST_F(RecordingTest, FindsADamagedByteThatStillInflates) {
  NamedFile file = test::fan_recording(5, 3, 20);
  const auto whole = file.bytes();
  std::size_t silent = 0;
  // Behind the head of the stream, and before its checksum.
  for (std::size_t from_end = 5; from_end + 2 < file.payload().size(); ++from_end) {
    std::string damaged(whole.begin(), whole.end());
    damaged[damaged.size() - from_end] = static_cast<char>(damaged[damaged.size() - from_end] ^ 0x10);
    write_file(path_, damaged);
    auto lazy = Recording::open({.path = path_, .geometry_path = {}, .pixels = Recording::Pixels::kFromFile});
    if (!lazy) continue;
    std::vector<std::uint8_t> frame(lazy->summary().geometry.frame_bytes());
    if (lazy->read_frame(2, frame)) ++silent;
    EXPECT_FALSE(lazy->check_pixels()) << from_end << " bytes before the end";
    EXPECT_FALSE(ReplaySource::create({.recording = {.path = path_, .geometry_path = {}}}));
  }
  EXPECT_GT(silent, 0U) << "some damage gives no error where it lies";
  write_file(path_, std::string(whole.begin(), whole.end()));
  auto recording =
      Recording::open({.path = path_, .geometry_path = {}, .pixels = Recording::Pixels::kFromFile});
  ASSERT_TRUE(recording);
  EXPECT_TRUE(recording->check_pixels());
}

struct Damage {
  const char* name;
  ErrorCode code;
  const char* sentence;  ///< part of the message
  std::function<std::string(NamedFile&)> bytes;
};

Damage header_damage(const char* name, ErrorCode code, const char* sentence, std::string_view field,
                     const std::string& value) {
  return {name, code, sentence, [field, value](NamedFile& file) {
            NamedFile::set(file.header, field, value);
            return file.bytes();
          }};
}

Damage frame_damage(const char* name, const char* sentence, std::size_t frame, std::string_view field,
                    const std::string& value) {
  return {name, ErrorCode::kBadInput, sentence, [frame, field, value](NamedFile& file) {
            NamedFile::set(file.frames[frame], field, value);
            return file.bytes();
          }};
}

const std::vector<Damage>& damages() {
  using enum ErrorCode;
  static const std::vector<Damage> kDamages = {
      {"Empty", kBadInput, "the file is empty", [](NamedFile&) { return std::string(); }},
      {"NoHeader", kBadInput, "the header ends too early",
       [](NamedFile&) { return std::string("NDims = 3\n"); }},
      {"Binary", kUnsupported, "this is no file of a known kind",
       [](NamedFile&) { return std::string(100, '\0'); }},
      {"TruncatedHeader", kBadInput, "the header ends too early",
       [](NamedFile& file) { return file.bytes().substr(0, 300); }},
      {"NulInALine", kBadInput, "holds byte 0x00",
       [](NamedFile& file) {
         NamedFile::set(file.header, "Comment", std::string("a\0b", 3));
         return file.bytes();
       }},
      {"OverlongLine", kBadInput, "is longer than 65536 bytes",
       [](NamedFile& file) {
         NamedFile::set(file.header, "Comment", std::string(70'000, 'x'));
         return file.bytes();
       }},
      {"EndlessLine", kBadInput, "is longer than 65536 bytes",
       [](NamedFile&) { return std::string(200'000, 'x'); }},
      {"NoEquals", kBadInput, "is \"hello\", expected Name = value",
       [](NamedFile&) { return std::string("hello\n"); }},
      {"RawBytesInAValue", kUnsupported, "is \"M???F\"",
       [](NamedFile& file) {
         NamedFile::set(file.header, "UltrasoundImageOrientation",
                        "M\xff\xc3\xa8"
                        "F");
         return file.bytes();
       }},
      {"TruncatedPixels", kBadInput, "bytes of compressed pixels follow the header",
       [](NamedFile& file) {
         std::string bytes = file.bytes();
         bytes.resize(bytes.size() - 5);
         return bytes;
       }},
      {"TruncatedPlainPixels", kBadInput, "239 bytes of pixels follow the header, expected 240",
       [](NamedFile& file) {
         file.compressed = false;
         std::string bytes = file.bytes();
         bytes.pop_back();
         return bytes;
       }},
      {"TruncatedStream", kBadInput, "its compressed pixels are damaged or cut off",
       [](NamedFile& file) {
         NamedFile::set(file.header, "CompressedDataSize", "20");
         return file.bytes();
       }},
      {"DamagedStream", kBadInput, "its compressed pixels are damaged or cut off",
       [](NamedFile& file) {
         std::string bytes = file.bytes();
         bytes[bytes.size() - 2] ^= 0x55;  // the checksum
         return bytes;
       }},
      {"FewerPixelsThanStated", kBadInput, "its compressed pixels are 192 bytes, expected 240",
       [](NamedFile& file) {
         file.pixels.resize(4 * 48);
         return file.bytes();
       }},
      {"MorePixelsThanStated", kBadInput, "its compressed pixels are more than its DimSize",
       [](NamedFile& file) {
         file.pixels.resize(6 * 48);
         return file.bytes();
       }},
      header_damage("CompressedSizeBeyondTheFile", kBadInput,
                    "expected the 99999999 of its CompressedDataSize", "CompressedDataSize", "99999999"),
      header_damage("CompressedSizeNoNumber", kBadInput, "expected a number of bytes", "CompressedDataSize",
                    "-1"),
      {"SizeThatTheStreamCannotHold", kBadInput, "compressed bytes cannot hold its DimSize",
       [](NamedFile& file) {
         // Small enough for the file with its header, too large for its few compressed bytes.
         NamedFile::set(file.header, "CompressedDataSize", "10");
         NamedFile::set(file.header, "DimSize", "100 200 5");
         return file.bytes();
       }},
      {"HeaderLineTwice", kBadInput, "expected the same as before, ",
       [](NamedFile& file) {
         std::string bytes = file.bytes();
         bytes.insert(bytes.find("DimSize"), "UltrasoundImageOrientation = MNA\n");
         return bytes;
       }},
      {"AngleOfAFrameTwice", kBadInput, "expected the same as before, ",
       [](NamedFile& file) {
         file.frames[1].emplace_back("MotorAngleDeg", "30");
         return file.bytes();
       }},
      {"StatusOfAFrameTwice", kBadInput, "expected the same as before, ",
       [](NamedFile& file) {
         file.frames[1].emplace_back("ImageStatus", "OK");
         file.frames[1].emplace_back("ImageStatus", "INVALID");
         return file.bytes();
       }},
      header_damage("SizeThatTheFileCannotHold", kBadInput, "23 compressed bytes cannot hold its DimSize",
                    "DimSize", "4096 4096 100"),
      header_damage("SizeBeyondTheLimit", kBadInput, "bytes of pixels", "DimSize", "4096 4096 1000000"),
      header_damage("SizeOverflows", kBadInput, "expected three numbers", "DimSize", "99999999999 6 5"),
      header_damage("ZeroFrames", kBadInput, "expected three numbers", "DimSize", "8 6 0"),
      header_damage("ZeroColumns", kBadInput, "expected three numbers", "DimSize", "0 6 5"),
      header_damage("NegativeSize", kBadInput, "expected three numbers", "DimSize", "8 -6 5"),
      header_damage("TwoSizes", kBadInput, "expected three numbers", "DimSize", "8 6"),
      header_damage("FourSizes", kBadInput, "expected three numbers", "DimSize", "8 6 5 1"),
      header_damage("SizeNoNumber", kBadInput, "expected three numbers", "DimSize", "8 six 5"),
      header_damage("FewerFramesThanDescribed", kBadInput,
                    "the header describes frame 4, expected the 4 frames", "DimSize", "8 6 4"),
      header_damage("FiveDimensions", kUnsupported, "expected 3: columns, rows and frames", "NDims", "5"),
      header_damage("Floats", kUnsupported, "expected MET_UCHAR", "ElementType", "MET_FLOAT"),
      header_damage("SixteenBit", kBadInput, "its compressed pixels are 240 bytes, expected 480",
                    "ElementType", "MET_USHORT"),
      header_damage("Colour", kUnsupported, "expected 1", "ElementNumberOfChannels", "3"),
      header_damage("Text", kUnsupported, "expected True", "BinaryData", "False"),
      header_damage("UnknownOrientation", kUnsupported,
                    "is \"MX\", expected MF, MN, UF, UN, FM, FU, NM or NU, with or without A or D behind",
                    "UltrasoundImageOrientation", "MX"),
      header_damage("ElevationInThePlane", kUnsupported, "is \"AMF\", expected MF, MN,",
                    "UltrasoundImageOrientation", "AMF"),
      header_damage("UnknownFrameKind", kBadInput,
                    "FanlightFrameKind is \"polar\", expected cartesian, convex-lines or linear-lines",
                    "FanlightFrameKind", "polar"),
      {"LinesTooFarApart", kBadInput, "line_pitch_deg is 11, expected 0.001 to 10",
       [](NamedFile& file) {
         NamedFile::set(file.header, "FanlightFrameKind", "convex-lines");
         NamedFile::set(file.header, "FanlightProbeRadiusMm", "40");
         NamedFile::set(file.header, "FanlightLinePitchDeg", "11");
         return file.bytes();
       }},
      header_damage("RadioFrequency", kUnsupported, "expected BRIGHTNESS", "UltrasoundImageType", "RF_REAL"),
      header_damage("NoTimeAxis", kUnsupported, "its Kinds name no time axis", "Kinds",
                    "domain domain domain"),
      header_damage("NoImage", kUnsupported, "expected Image", "ObjectType", "Tube"),
      header_damage("CompressionNeitherTrueNorFalse", kBadInput, "expected True or False", "CompressedData",
                    "Maybe"),
      header_damage("GeometryNoNumber", kBadInput, "FanlightFaceRow is \"top\", expected a number",
                    "FanlightFaceRow", "top"),
      header_damage("GeometryOutOfRange", kBadInput, "motor_radius_mm is -3", "FanlightMotorRadiusMm", "-3"),
      {"FileElsewhere", kUnsupported, "\"ElementDataFile\" is \"../sweep.zraw\", expected LOCAL",
       [](NamedFile&) { return std::string("ElementDataFile = ../sweep.zraw\n"); }},
      {"ManyFiles", kUnsupported, "\"ElementDataFile\" is \"LIST\", expected LOCAL",
       [](NamedFile&) { return std::string("ElementDataFile = LIST\n"); }},
      {"FramesApart", kBadInput, "frame 102 after frame 1, expected the frames in their order",
       [](NamedFile&) {
         return std::string("DimSize = 8 6 200\nSeq_Frame0000_Timestamp = 0\nSeq_Frame0102_Timestamp = 1\n");
       }},
      {"NoOrientation", kUnsupported, "no UltrasoundImageOrientation, expected MF, MN,",
       [](NamedFile& file) {
         NamedFile::remove(file.header, "UltrasoundImageOrientation");
         return file.bytes();
       }},
      {"NoElementType", kBadInput, "no ElementType",
       [](NamedFile& file) {
         NamedFile::remove(file.header, "ElementType");
         return file.bytes();
       }},
      {"NoSize", kBadInput, "the header has no size of the frames",
       [](NamedFile&) { return std::string("ElementType = MET_UCHAR\nElementDataFile = LOCAL\n"); }},
      {"FramesWithoutASize", kBadInput, "the header has no size of the frames",
       [](NamedFile&) {
         return std::string(
             "ElementType = MET_UCHAR\nSeq_Frame0000_Timestamp = 1\nElementDataFile = LOCAL\n");
       }},
      {"SizeBelowTheFramesDescribed", kBadInput, "expected the 3 frames that the lines before it describe",
       [](NamedFile&) { return std::string("Seq_Frame0002_Timestamp = 1\nDimSize = 8 6 2\n"); }},
      {"FrameWithoutNumber", kBadInput, "expected Seq_Frame0000_Name",
       [](NamedFile& file) {
         NamedFile::set(file.header, "Seq_Frame_Timestamp", "1");
         return file.bytes();
       }},
      {"TooManyOwnFields", kBadInput, "more than 64 Fanlight fields",
       [](NamedFile& file) {
         for (int i = 0; i < 70; ++i) NamedFile::set(file.header, fmt::format("Fanlight{}", i), "1");
         return file.bytes();
       }},
      frame_damage("AngleNoNumber", "\"Seq_Frame0002_MotorAngleDeg\" is \"12deg\", expected degrees", 2,
                   "MotorAngleDeg", "12deg"),
      frame_damage("AngleNotFinite", "expected degrees", 2, "MotorAngleDeg", "nan"),
      frame_damage("TimeNoNumber", "expected seconds", 2, "Timestamp", ""),
      frame_damage("TimeGoesBack", "out of order", 3, "Timestamp", "12.55"),
      frame_damage("TimeJumps", "out of order", 4, "Timestamp", "1e300"),
      frame_damage("VolumeNoNumber", "expected a whole number from 0", 2, "VolumeIndex", "-1"),
      frame_damage("VolumeGoesBack", "the VolumeIndex of frame 3 goes back from 5 to 0", 2, "VolumeIndex",
                   "5"),
      frame_damage("StatusUnknown", "expected OK or INVALID", 2, "ImageStatus", "FINE"),
      frame_damage("DirectionUnknown", "expected FORWARD or BACKWARD", 2, "SweepDirection", "LEFT"),
      frame_damage("TransformTooShort", "expected a matrix of 16 numbers", 2, "ImageToReferenceTransform",
                   "1 0 0"),
      {"AngleMissingOnOneFrame", kBadInput, "frame 3 has no MotorAngleDeg",
       [](NamedFile& file) {
         NamedFile::remove(file.frames[3], "MotorAngleDeg");
         return file.bytes();
       }},
      {"NoAngles", kBadInput, "no frame has a MotorAngleDeg",
       [](NamedFile& file) {
         file.remove_all("MotorAngleDeg");
         return file.bytes();
       }},
      {"TimeMissingOnOneFrame", kBadInput, "frame 3 has no Timestamp",
       [](NamedFile& file) {
         NamedFile::remove(file.frames[3], "Timestamp");
         return file.bytes();
       }},
      {"VolumeMissingOnOneFrame", kBadInput, "frame 3 has no VolumeIndex",
       [](NamedFile& file) {
         NamedFile::remove(file.frames[3], "VolumeIndex");
         return file.bytes();
       }},
      {"TimeStandsStill", kBadInput, "all frames have the same Timestamp",
       [](NamedFile& file) {
         file.set_all("Timestamp", "3");
         return file.bytes();
       }},
      {"AngleStandsStill", kBadInput, "the motor angle stays at 5 deg, expected a sweep",
       [](NamedFile& file) {
         file.set_all("MotorAngleDeg", "5");
         return file.bytes();
       }},
      {"AllInvalid", kBadInput, "no frame is usable",
       [](NamedFile& file) {
         file.set_all("ImageStatus", "INVALID");
         return file.bytes();
       }},
      {"OneFrame", kBadInput, "there is a single frame",
       [](NamedFile& file) {
         file.frames.resize(1);
         file.pixels.resize(48);
         return file.bytes();
       }},
  };
  return kDamages;
}

class DamagedRecordingTest : public RecordingTest, public testing::WithParamInterface<std::size_t> {};

TEST_P(DamagedRecordingTest, IsRefusedInOneSentence) {
  const Damage& damage = damages()[GetParam()];
  NamedFile file = test::fan_recording(5, 1, 20);
  const auto refused = open(damage.bytes(file));
  ASSERT_FALSE(refused);
  const std::string& message = refused.error().message;
  EXPECT_EQ(refused.error().code, damage.code) << message;
  EXPECT_TRUE(message.starts_with(path_.string() + ": ")) << message;
  EXPECT_NE(message.find(damage.sentence), std::string::npos) << message;
  EXPECT_NE(message.find("expected"), std::string::npos) << message;
  EXPECT_LT(message.size(), 400U);
  EXPECT_TRUE(std::ranges::all_of(message, [](char c) { return c >= ' ' && c <= '~'; })) << message;
}

INSTANTIATE_TEST_SUITE_P(All, DamagedRecordingTest, testing::Range(std::size_t{0}, damages().size()),
                         [](const auto& tested) { return std::string(damages()[tested.param].name); });

// After any truncation or change of a byte the result is a recording or an error, never a crash. The
// sanitizers run it too.
TEST_F(RecordingTest, AnswersForEveryPrefixAndEveryChangedByte) {
  const std::string whole = test::fan_recording(3, 2, 20).bytes();
  for (std::size_t size = 0; size < whole.size(); size += 7)
    EXPECT_FALSE(open(std::string_view(whole).substr(0, size)));
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ (1 << (at % 7)));
    (void)open(changed);
  }
}

TEST_F(RecordingTest, RefusesWhatIsNoFile) {
  EXPECT_EQ(Recording::open({.path = folder_ / "none.mha", .geometry_path = {}}).error().code,
            ErrorCode::kNotFound);
  const auto directory = Recording::open({.path = folder_.path(), .geometry_path = {}});
  ASSERT_FALSE(directory);
  EXPECT_NE(directory.error().message.find("there are no such pictures"), std::string::npos);
  EXPECT_FALSE(Recording::open({.path = "/dev/zero", .geometry_path = {}}));
}

}  // namespace
}  // namespace fanlight
