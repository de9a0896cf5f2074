// SPDX-License-Identifier: Apache-2.0
// NIfTI-1 volumes as recordings.
#include "acquisition/replay/nifti_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cstring>
#include <string>

#include "acquisition/convert/converted_files.hpp"
#include "acquisition/replay/recording.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr std::uint32_t kSize[] = {12, 20, 30};

/// A header of another program, with a qform and no sform.
class Nifti {
 public:
  explicit Nifti(bool big_endian = false) : big_endian_(big_endian) {
    put<std::int32_t>(0, 348);
    put<std::int16_t>(40, 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put(42 + 2 * axis, static_cast<std::int16_t>(kSize[axis]));
      put(80 + 4 * axis, 0.5F + 0.1F * static_cast<float>(axis));
    }
    put<std::int16_t>(48, 1);
    put<float>(76, 1);
    put<std::int16_t>(70, 2);
    put<std::int16_t>(72, 8);
    put<float>(108, 352);
    header_[123] = 2;
    put<std::int16_t>(252, 1);
    std::memcpy(header_.data() + 344, "n+1", 4);
  }

  template <typename T>
  Nifti& put(std::size_t offset, T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big_endian_) std::ranges::reverse(bytes);
    std::ranges::copy(bytes, header_.begin() + static_cast<std::ptrdiff_t>(offset));
    return *this;
  }
  Nifti& put_byte(std::size_t offset, char value) {
    header_[offset] = value;
    return *this;
  }

  /// With voxels of 1 or 2 bytes: no two of a row, a column or a beam are equal.
  std::string file(int bytes = 1, int volumes = 1) const {
    std::string all = header_;
    for (int volume = 0; volume < volumes; ++volume) {
      for (std::uint32_t i = 0; i < kSize[0] * kSize[1] * kSize[2]; ++i) {
        const int value = level(i % kSize[0], i / kSize[0] % kSize[1], i / (kSize[0] * kSize[1])) + volume;
        if (bytes == 2 && big_endian_) all.push_back(0);
        all.push_back(static_cast<char>(value));
        if (bytes == 2 && !big_endian_) all.push_back(0);
      }
    }
    return all;
  }

  static int level(std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return static_cast<int>(20 + 2 * i + 5 * j + 3 * k);
  }

 private:
  bool big_endian_;
  std::string header_ = std::string(352, '\0');
};

std::string gzipped(const std::string& plain) {
  z_stream stream{};
  deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY);
  std::string packed(plain.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  stream.avail_in = static_cast<uInt>(plain.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

class NiftiTest : public testing::Test {
 protected:
  Result<NiftiVolumes> read(const std::string& bytes, const char* name = "x.nii") {
    write_file(folder_ / name, bytes);
    return read_nifti(folder_ / name, 1 << 24);
  }
  std::string refusal(const std::string& bytes, const char* name = "x.nii") {
    const auto volumes = read(bytes, name);
    return volumes ? "read" : volumes.error().message;
  }
  bool contains(const std::string& sentence, const std::string& part) {
    if (sentence.find(part) != sentence.npos) return true;
    ADD_FAILURE() << sentence;
    return false;
  }

  TemporaryFolder folder_;
};

TEST_F(NiftiTest, ReadsPlainAndCompressedFilesOfEitherByteOrder) {
  for (const bool big_endian : {false, true}) {
    for (const bool packed : {false, true}) {
      const Nifti nifti = Nifti(big_endian).put<std::int16_t>(70, 512).put<std::int16_t>(72, 16);
      const std::string file = nifti.file(2);
      const auto volumes = packed ? read(gzipped(file), "x.nii.gz") : read(file);
      ASSERT_TRUE(volumes) << volumes.error().message;
      EXPECT_EQ(volumes->grid.size, (std::array{kSize[0], kSize[1], kSize[2]}));
      EXPECT_NEAR(volumes->grid.spacing_mm[2], 0.7, 1e-6);
      EXPECT_FALSE(volumes->grid.is_left_handed);
      EXPECT_EQ(volumes->format, (PixelFormat{.bytes = 2, .big_endian = big_endian}));
      EXPECT_EQ(volumes->voxels.size(), 2U * kSize[0] * kSize[1] * kSize[2]);
    }
  }
}

TEST_F(NiftiTest, IsARecordingOfPlanes) {
  write_file(folder_ / "x.nii.gz",
             gzipped(Nifti().put<std::int16_t>(40, 4).put<std::int16_t>(48, 2).file(1, 2)));
  const auto recording = Recording::open({.path = folder_ / "x.nii.gz", .geometry_path = {}});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_TRUE(recording->is_grid());
  EXPECT_TRUE(recording->summary().geometry.unknown_beams);
  EXPECT_EQ(recording->summary().sweeps, 2U);
  EXPECT_EQ(recording->summary().columns, kSize[0]);
  const std::size_t middle = recording->summary().frames / 4;
  const auto pixels = recording->frame_pixels(middle);
  EXPECT_NEAR(pixels[5 * kSize[0] + 3] - pixels[5 * kSize[0] + 2], 2, 1);
  EXPECT_NEAR(pixels[6 * kSize[0] + 3] - pixels[5 * kSize[0] + 3], 5, 1);
}

TEST_F(NiftiTest, KeepsThePlaceOfAFileOfItsOwn) {
  GridVolume grid{.origin_mm = {-3, 5, -7}, .spacing_mm = 0.5, .size = {12, 20, 30}, .voxels = {}};
  grid.voxels.resize(12 * 20 * 30, 9);
  ASSERT_TRUE(write_grid_nifti(folder_ / "own.nii", grid));
  const auto volumes = read_nifti(folder_ / "own.nii", 1 << 20);
  ASSERT_TRUE(volumes) << volumes.error().message;
  ASSERT_TRUE(volumes->grid.origin_mm);
  EXPECT_EQ(*volumes->grid.origin_mm, (std::array{-3.0, 5.0, -7.0}));
  EXPECT_EQ(volumes->voxels, grid.voxels);
  EXPECT_TRUE(volumes->notes.empty());
}

TEST_F(NiftiTest, TakesUnitsHandednessAndTimes) {
  const auto metres = read(Nifti().put_byte(123, 1).put(80, 5e-4F).put(84, 5e-4F).put(88, 5e-4F).file());
  ASSERT_TRUE(metres) << metres.error().message;
  EXPECT_NEAR(metres->grid.spacing_mm[0], 0.5, 1e-6);
  EXPECT_TRUE(read(Nifti().put<float>(76, -1).file())->grid.is_left_handed);
  const auto timed = read(Nifti()
                              .put<std::int16_t>(40, 4)
                              .put<std::int16_t>(48, 3)
                              .put<float>(92, 250)
                              .put_byte(123, 2 + 16)
                              .file(1, 3));
  ASSERT_TRUE(timed) << timed.error().message;
  EXPECT_EQ(timed->grid.volume_times_s, (std::vector{0.0, 0.25, 0.5}));
  Nifti sheared;
  sheared.put<std::int16_t>(254, 1).put<float>(280, 1).put<float>(284, 0.5).put<float>(300, 1).put<float>(320,
                                                                                                          1);
  EXPECT_TRUE(contains(refusal(sheared.file()), "do not stand at right angles"));
}

TEST_F(NiftiTest, RefusesWhatItCannotReadInOneSentence) {
  const std::string good = Nifti().file();
  EXPECT_TRUE(contains(refusal(good.substr(0, 200)), "ends in its header"));
  EXPECT_TRUE(contains(refusal(good.substr(0, good.size() - 5)), "cannot hold its 7200 bytes of voxels"));
  EXPECT_TRUE(contains(refusal(Nifti().put<std::int16_t>(70, 16).file()), "values are of the type 16"));
  EXPECT_TRUE(contains(refusal(Nifti().put<std::int16_t>(42, -4).file()), "axis 1 has -4 voxels"));
  EXPECT_TRUE(contains(refusal(Nifti().put<std::int16_t>(40, 2).file()), "it has 2 axes"));
  EXPECT_TRUE(contains(refusal(Nifti().put<float>(108, 1e30F).file()), "voxels begin at byte"));
  EXPECT_TRUE(contains(refusal(Nifti().put<float>(80, std::nanf("")).file()), "voxels of nan mm"));
  EXPECT_TRUE(contains(refusal(Nifti().put<float>(112, -1).file()), "weaker echo"));
  std::string packed = gzipped(good);
  EXPECT_TRUE(contains(refusal(packed.substr(0, packed.size() - 4), "x.nii.gz"), "damaged or cut off"));
  packed[packed.size() / 2] ^= 0x10;
  EXPECT_TRUE(contains(refusal(packed, "x.nii.gz"), "damaged or cut off"));
}

}  // namespace
}  // namespace fanlight::test
