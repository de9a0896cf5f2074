// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/foreign_format.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fanlight::test {
namespace {

using namespace std::string_literals;

std::string kind_of(std::string bytes, const std::filesystem::path& path = "sweep.bin") {
  const auto found =
      foreign_format({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, path);
  return found ? std::string(found->what) : "";
}

TEST(FileKindTest, NamesFormatsByTheirFirstBytes) {
  EXPECT_EQ(kind_of(std::string(344, '\0') + "ni1\0"s + "rest"),
            "the header of a NIfTI volume, whose voxels are in another file");
  EXPECT_EQ(kind_of("<VTKFile type=\"ImageData\">"), "a VTK file");
  EXPECT_EQ(kind_of("II*\0\x08"s), "a TIFF picture");
  EXPECT_EQ(kind_of("\x89PNG\r\n"), "a PNG picture");
  EXPECT_EQ(kind_of(std::string(128, '\0') + "DICM"), "a DICOM file");
  EXPECT_EQ(kind_of("\0\0\0\x18"s + "ftypmp42"), "an MP4 video");
  EXPECT_EQ(kind_of("\x1F\x8B\x08"), "a file compressed with gzip");
}

TEST(FileKindTest, NamesFormatsWithoutASignatureByTheEndOfTheName) {
  EXPECT_EQ(kind_of("\x01\x02", "liver_sweep.imf"), "an ImFusion file");
  EXPECT_EQ(kind_of("\x01\x02", "frames.RAW"), "raw pixels without a header");
  EXPECT_EQ(kind_of("\x7F\x02", "sweep.igs.mha"), "no file of a known kind");
}

TEST(FileKindTest, LeavesHeadersOfTextToTheReader) {
  EXPECT_EQ(kind_of("ObjectType = Image\n", "sweep.raw"), "");
  EXPECT_EQ(kind_of("NDims = 3\n"), "");
  EXPECT_EQ(kind_of("NRRD0004\ntype: uchar\n"), "");
  EXPECT_EQ(kind_of("KRETZFILE 1.0   "), "");
  EXPECT_EQ(kind_of("anything = else\n"), "");
  EXPECT_EQ(kind_of(""), "");
}

}  // namespace
}  // namespace fanlight::test
