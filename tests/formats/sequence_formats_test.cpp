// SPDX-License-Identifier: Apache-2.0
// One recording in every form that is read: MetaImage and NRRD, in one file or two, plain or packed, 8 or 16
// bit, signed or not, in both byte orders.
#include <gtest/gtest.h>

#include <array>

#include "acquisition/replay/recording.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/nrrd_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

/// Pixel values 0 to 250 in steps of 50, as a format stores them: the smallest value is 0 there.
struct Type {
  const char* meta;
  const char* nrrd;
  PixelFormat format;
};
constexpr std::array kTypes = {
    Type{"MET_UCHAR", "uint8", {}},
    Type{"MET_CHAR", "int8_t", {.is_signed = true}},
    Type{"MET_USHORT", "unsigned short", {.bytes = 2}},
    Type{"MET_SHORT", "int16", {.bytes = 2, .is_signed = true}},
    Type{"MET_USHORT", "ushort", {.bytes = 2, .big_endian = true}},
    Type{"MET_SHORT", "short", {.bytes = 2, .is_signed = true, .big_endian = true}},
};

struct Form {
  bool nrrd;
  bool packed;
  bool two_files;
};

using Case = std::tuple<std::size_t, bool, bool, bool>;

class SequenceFormatTest : public testing::TestWithParam<Case> {
 protected:
  static constexpr std::size_t kPixels = std::size_t{8} * 6 * 10;

  static int value(std::size_t pixel) { return static_cast<int>(pixel * 7 % 251); }

  static std::string stored(PixelFormat format) {
    std::string bytes;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      const auto code = static_cast<unsigned>(format.smallest() + value(pixel));
      const char low = static_cast<char>(code & 255U);
      const char high = static_cast<char>(code >> 8 & 255U);
      if (format.bytes == 2 && format.big_endian) bytes += high;
      bytes += low;
      if (format.bytes == 2 && !format.big_endian) bytes += high;
    }
    return bytes;
  }

  std::filesystem::path write(const Type& type, const Form& form) const {
    const PixelFormat format = type.format;
    NamedFile file = fan_recording(5, 2, 20);
    if (!format.is_grey()) {
      file.header.emplace_back("FanlightWindowBlack", fmt::format("{}", format.smallest()));
      file.header.emplace_back("FanlightWindowWhite", fmt::format("{}", format.smallest() + 255));
    }
    const std::string bytes = stored(format);
    if (form.nrrd) {
      const std::string data = form.packed ? gzipped(bytes) : bytes;
      const std::string text =
          nrrd_header(file, fmt::format("type: {}\nendian: {}\nencoding: {}\n{}", type.nrrd,
                                        format.big_endian ? "big" : "little", form.packed ? "gzip" : "raw",
                                        form.two_files ? "data file: x.bin\n" : ""));
      if (form.two_files) write_file(folder_ / "x.bin", data);
      write_file(folder_ / "x.seq.nrrd", form.two_files ? text : text + "\n" + data);
      return folder_ / "x.seq.nrrd";
    }
    file.pixels.assign(bytes.begin(), bytes.end());
    file.compressed = form.packed;
    NamedFile::set(file.header, "ElementType", type.meta);
    NamedFile::set(file.header, "BinaryDataByteOrderMSB", format.big_endian ? "True" : "False");
    std::string whole = file.bytes();
    if (!form.two_files) {
      write_file(folder_ / "x.igs.mha", whole);
      return folder_ / "x.igs.mha";
    }
    const std::string local = "ElementDataFile = LOCAL\n";
    const auto end = whole.find(local);
    write_file(folder_ / "x.zraw", whole.substr(end + local.size()));
    write_file(folder_ / "x.igs.mhd", whole.substr(0, end) + "ElementDataFile = x.zraw\n");
    return folder_ / "x.igs.mhd";
  }

  TemporaryFolder folder_;
};

TEST_P(SequenceFormatTest, GivesTheSameFrames) {
  const auto& [type, nrrd, packed, two_files] = GetParam();
  const auto path = write(kTypes[type], {.nrrd = nrrd, .packed = packed, .two_files = two_files});
  const auto recording = Recording::open({.path = path, .geometry_path = {}});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().format, kTypes[type].format);
  EXPECT_EQ(recording->summary().frames, 10U);
  EXPECT_EQ(recording->summary().sweeps, 2U);
  EXPECT_NEAR(recording->summary().largest_angle_deg, 20, 1e-9);
  const std::size_t frame_pixels = std::size_t{8} * 6;
  for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
    ASSERT_EQ(recording->frame_pixels(pixel / frame_pixels)[pixel % frame_pixels], value(pixel)) << pixel;
  }
  EXPECT_EQ(recording->summary().notes.size(), kTypes[type].format.is_grey() ? 0U : 1U);
}

INSTANTIATE_TEST_SUITE_P(All, SequenceFormatTest,
                         testing::Combine(testing::Range(std::size_t{0}, kTypes.size()), testing::Bool(),
                                          testing::Bool(), testing::Bool()));

class NrrdTest : public testing::Test {
 protected:
  Result<Recording> open(const std::string& text) {
    const auto path = folder_ / "x.nrrd";
    write_file(path, text);
    return Recording::open({.path = path, .geometry_path = {}});
  }
  static std::string changed(const std::string& from, const std::string& to) {
    const NamedFile file = fan_recording(5, 2, 20);
    std::string text = nrrd_header(file, "type: uint8\nencoding: raw\n");
    const auto at = text.find(from);
    if (at == std::string::npos) ADD_FAILURE() << from;
    text.replace(at, from.size(), to);
    return text + "\n" + std::string(file.pixels.begin(), file.pixels.end());
  }
  TemporaryFolder folder_;
};

TEST_F(NrrdTest, IsRefusedInOneSentence) {
  using enum ErrorCode;
  struct Change {
    const char* from;
    const char* to;
    ErrorCode code;
    const char* sentence;
  };
  for (const Change& change : {
           Change{"uint8", "float", kUnsupported, "expected uint8, int8, uint16 or int16"},
           Change{"type: uint8\n", "", kBadInput, "the header has no type"},
           Change{"encoding: raw\n", "", kBadInput, "the header has no encoding"},
           Change{"raw", "bzip2", kUnsupported, "expected raw or gzip"},
           Change{"uint8", "uint16", kBadInput, "the header has no endian"},
           Change{"domain domain list", "domain domain domain", kUnsupported,
                  "a volume on a grid needs a spacing"},
           Change{"domain domain list", "domain list", kBadInput, "2 kinds, expected one for each axis"},
           Change{"dimension: 3", "dimension: 2", kUnsupported, "expected 3 or 4"},
           Change{"sizes: 8 6 10", "sizes: 8 6 10 1", kBadInput, "as many numbers as its dimension 3"},
           Change{"sizes: 8 6 10", "sizes: 8 6 11", kBadInput,
                  "480 bytes of pixels follow the header, expected 528"},
           Change{"sizes: 8 6 10", "sizes: 8 6 -1", kBadInput, "three or four numbers"},
           Change{"sizes: 8 6 10\n", "", kBadInput, "the header has no sizes"},
           Change{"encoding: raw", "encoding: raw\nbyte skip: 3", kUnsupported, "expected 0"},
           Change{"encoding: raw", "encoding: raw\ndata file: ../x", kUnsupported, "in the same folder"},
           Change{"encoding: raw", "encoding: raw\ndata file: LIST", kUnsupported, "in the same folder"},
           Change{"encoding: raw", "encoding: raw\ndata file: y", kNotFound, "there is no such file"},
           Change{"encoding: raw", "encoding: raw\nencoding: gzip", kBadInput, "the same as before, \"raw\""},
           Change{"encoding: raw", "encoding raw", kBadInput, "expected field: value, or key:=value"},
           Change{"BRIGHTNESS", "RF_REAL", kUnsupported, "expected BRIGHTNESS"},
           Change{"MFA", "MX", kUnsupported, "expected MF, MN"},
       }) {
    const auto refused = open(changed(change.from, change.to));
    ASSERT_FALSE(refused) << change.to;
    EXPECT_EQ(refused.error().code, change.code) << refused.error().message;
    EXPECT_NE(refused.error().message.find(change.sentence), std::string::npos) << refused.error().message;
  }
}

TEST_F(NrrdTest, TakesAPlaneAFrameAndTimeWithoutKinds) {
  EXPECT_TRUE(open(changed("dimension: 3\nsizes: 8 6 10\nkinds: domain domain list",
                           "dimension: 4\nsizes: 8 6 1 10\nkinds: domain domain domain list")));
  EXPECT_TRUE(open(changed("kinds: domain domain list\n", "# made by hand\n")));
  EXPECT_TRUE(open(changed("domain domain list", "domain domain time")));
}

TEST_F(NrrdTest, TakesFramesOnTheFirstAxis) {
  const NamedFile file = fan_recording(5, 2, 20);
  std::string text = nrrd_header(file, "type: uint8\nencoding: raw\n");
  text.replace(text.find("8 6 10"), 6, "10 8 6");
  text.replace(text.find("domain domain list"), 18, "list domain domain");
  text += "\n";
  for (std::size_t pixel = 0; pixel < 48; ++pixel) {
    for (std::size_t frame = 0; frame < 10; ++frame) text += static_cast<char>(frame * 20 + pixel % 17);
  }
  const auto recording = open(text);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->summary().frames, 10U);
  for (std::size_t pixel = 0; pixel < 480; ++pixel)
    ASSERT_EQ(recording->frame_pixels(pixel / 48)[pixel % 48], pixel / 48 * 20 + pixel % 48 % 17) << pixel;
}

/// As Slicer's documentation describes its volume sequences (Docs/developer_guide/modules/sequences.md).
TEST_F(NrrdTest, TakesWhatSlicerSaves) {
  const std::string fields =
      "NRRD0005\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\nencoding: raw\nspace origin: "
      "(0,0,0)\n"
      "sizes: 8 6 1 4\nspace directions: (0.5,0,0) (0,0.25,0) (0,0,1) none\nkinds: domain domain domain "
      "list\n"
      "labels: \"\" \"\" \"\" \"time\"\naxis 3 index type:=numeric\naxis 3 index values:=1 1.5 2 2.75\n"
      "DataNodeClassName:=vtkMRMLScalarVolumeNode\n\n";
  write_file(folder_ / "x.nrrd.toml",
             "face_column = 3.5\nface_row = 0\nmotor_radius_mm = 28\nangles_deg = [-9, -3, 3, 9]\n");
  const auto planes = open(fields + std::string(192, 'x'));
  ASSERT_TRUE(planes) << planes.error().message;
  EXPECT_EQ(planes->summary().frames, 4U);
  EXPECT_NEAR(planes->summary().duration_s, 1.75, 1e-9);
  EXPECT_EQ(planes->summary().geometry.pixel_height_mm, 0.25);
  EXPECT_NE(planes->summary().notes.at(0).find("no orientation"), std::string::npos);

  std::filesystem::remove(folder_ / "x.nrrd.toml");
  std::string volumes = fields;
  volumes.replace(volumes.find("8 6 1 4"), 7, "8 6 5 4");
  const auto grid = open(volumes + std::string(960, 'x'));
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_EQ(grid->summary().sweeps, 4U);
  EXPECT_NEAR(static_cast<double>(grid->frames()[grid->sweeps()[3].first_frame].time_ns) * 1e-9, 1.75, 1e-9);

  // The order of older versions.
  std::string first = volumes;
  first.replace(first.find("8 6 5 4"), 7, "4 8 6 5");
  first.replace(first.find("domain domain domain list"), 25, "list domain domain domain");
  first.replace(first.find("(0.5,0,0) (0,0.25,0) (0,0,1) none"), 33, "none (0.5,0,0) (0,0.25,0) (0,0,1)");
  std::string interleaved;
  for (int voxel = 0; voxel < 240; ++voxel) interleaved += "abcd";
  const auto older = open(first + interleaved);
  ASSERT_TRUE(older) << older.error().message;
  ASSERT_EQ(older->summary().sweeps, 4U);
  EXPECT_EQ(older->frame_pixels(older->sweeps()[2].first_frame)[5], 'c');
}

TEST_F(NrrdTest, ChoosesAWindowAndTellsIt) {
  NamedFile file = fan_recording(5, 2, 20);
  std::string pixels;
  for (std::size_t pixel = 0; pixel < 480; ++pixel) {
    const std::size_t value = pixel % 2 == 0 ? 1000 : 3000;
    pixels += static_cast<char>(value & 255);
    pixels += static_cast<char>(value >> 8);
  }
  const auto recording =
      open(nrrd_header(file, "type: uint16\nencoding: gzip\nendian: little\n") + "\n" + gzipped(pixels));
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().window, (ValueWindow{.black = 1000, .white = 3000}));
  EXPECT_EQ(recording->frame_pixels(3)[0], 0);
  EXPECT_EQ(recording->frame_pixels(3)[1], 255);
  ASSERT_EQ(recording->summary().notes.size(), 1U);
  EXPECT_NE(
      recording->summary().notes[0].find("1000 is shown black and 3000 white, chosen from their values"),
      std::string::npos)
      << recording->summary().notes[0];
}

}  // namespace
}  // namespace fanlight::test
