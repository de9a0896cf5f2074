// SPDX-License-Identifier: Apache-2.0
// Ten thousand damaged files of each format, and every end of the last 64 KiB: a clear refusal or a shorter
// recording, never a crash, and no more memory than the file justifies. The sanitizers run it too, with fewer
// files.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <random>

#include "acquisition/convert/dicom_volume.hpp"
#include "acquisition/replay/recording.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/kretz_file.hpp"
#include "tests/support/nrrd_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr int kFiles = kSanitized ? 300 : 10'000;
constexpr std::uint64_t kMostPeakBytes = 220'000'000;  // two copies of the zeros are this test's own

#ifdef FANLIGHT_DICOM
std::string dicom_volume() {
  const TemporaryFolder folder;
  GridVolume grid{.size = {8, 6, 8}};
  grid.voxels.assign(grid.bytes(), 100);
  EXPECT_TRUE(write_grid_dicom(folder / "x.dcm", grid, {}));
  std::ifstream file(folder / "x.dcm", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
#endif

std::string bytes_of(const std::string& format) {
  if (format == "kretz") return KretzFile::small().bytes();
#ifdef FANLIGHT_DICOM
  if (format == "dicom") return dicom_volume();
#endif
  if (format == "grid") {
    return "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 8 6 10\nspacings: 1 1 1\nencoding: raw\n\n" +
           std::string(480, 'x');
  }
  NamedFile file = fan_recording(5, 2, 20);
  for (std::size_t i = 0; i < file.pixels.size(); ++i) file.pixels[i] = static_cast<std::uint8_t>(i * 37);
  const std::string pixels(file.pixels.begin(), file.pixels.end());
  if (format == "mha") {
    file.compressed = false;
    return file.bytes();
  }
  if (format == "mha_zlib") return file.bytes();
  if (format == "nrrd") return nrrd_header(file, "type: uint8\nencoding: raw\n") + "\n" + pixels;
  return nrrd_header(file, "type: int16\nendian: big\nencoding: gzip\n") + "\n" + gzipped(pixels + pixels);
}

/// What a copy on the network, an editor or a bad disk does to a file.
std::string mutated(std::string bytes, std::mt19937& random) {
  const auto at = [&] { return random() % bytes.size(); };
  for (auto change = 1 + random() % 6; change > 0 && bytes.size() > 1; --change) {
    switch (random() % 6) {
      case 0:
        bytes[at()] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at(), 1 + random() % 40);
        break;
      case 2:
        bytes.insert(at(), bytes.substr(at(), random() % 80));
        break;
      case 3: {  // a number in the header
        const auto digit = bytes.find_first_of("0123456789", at());
        if (digit != std::string::npos) bytes.replace(digit, 1, random() % 2 == 0 ? "99999999" : "-1");
        break;
      }
      case 4:
        bytes.resize(at());
        break;
      default:
        bytes[at()] = static_cast<char>(bytes[at()] ^ (1 << (random() % 8)));
        break;
    }
  }
  return bytes;
}

class MutatedFilesTest : public testing::TestWithParam<const char*> {
 protected:
  /// Opens the file and reads it to its end; the frames of a recording, or 0.
  std::uint32_t frames_of(const std::string& bytes) {
    const auto path = folder_ / "x";
    write_file(path, bytes);
    auto recording =
        Recording::open({.path = path, .geometry_path = {}, .pixels = Recording::Pixels::kFromFile});
    if (!recording) {
      EXPECT_NE(recording.error().message.find("expected"), std::string::npos) << recording.error().message;
      return 0;
    }
    std::vector<std::uint8_t> pixels(recording->summary().geometry.frame_bytes());
    for (std::size_t frame = 0; frame < recording->summary().frames; ++frame) {
      if (!recording->read_frame(frame, pixels)) return static_cast<std::uint32_t>(frame);
    }
    return recording->summary().frames;
  }

  TemporaryFolder folder_;
};

TEST_P(MutatedFilesTest, AreRefusedOrRead) {
  std::mt19937 random(18);
  const std::string whole = bytes_of(GetParam());
  EXPECT_GE(frames_of(whole), 6U);
  int read = 0;
  for (int file = 0; file < kFiles; ++file) read += frames_of(mutated(whole, random)) > 0 ? 1 : 0;
  EXPECT_GT(read, kFiles / 250);
  EXPECT_LT(read, kFiles);
}

TEST_P(MutatedFilesTest, AreNeverLongerThanWhatIsThere) {
  const std::string whole = bytes_of(GetParam());
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_LT(frames_of(whole.substr(0, size)), 11U) << size;
}

#ifdef FANLIGHT_DICOM
INSTANTIATE_TEST_SUITE_P(Dicom, MutatedFilesTest, testing::Values("dicom"),
                         [](const auto& tested) { return std::string(tested.param); });
#endif
INSTANTIATE_TEST_SUITE_P(All, MutatedFilesTest,
                         testing::Values("mha", "mha_zlib", "nrrd", "nrrd_gzip", "kretz", "grid"),
                         [](const auto& tested) { return std::string(tested.param); });

std::uint64_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

TEST(HugeClaimsTest, TakeNoMemory) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    write_file(folder / name, bytes);
    const auto opened = Recording::open({.path = folder / name, .geometry_path = {}});
    EXPECT_FALSE(opened);
  };
  const std::uint64_t before = peak_bytes();
  NamedFile file = fan_recording(5, 2, 20);
  NamedFile::set(file.header, "DimSize", "4096 4096 1000000");
  refused("x.mha", file.bytes());
  NamedFile::set(file.header, "DimSize", "4 4 1000000");
  refused("x.mha", file.bytes());
  std::string nrrd = nrrd_header(fan_recording(5, 2, 20), "type: uint8\nencoding: gzip\n");
  nrrd.replace(nrrd.find("8 6 10"), 6, "4096 4096 400");
  // A bomb: a hundred megabytes of zeros in a hundred kilobytes.
  refused("x.nrrd", nrrd + "\n" + gzipped(std::string(100'000'000, '\0')));
  // The sanitizers' own memory, several times the program's, differs from run to run.
  EXPECT_TRUE(kSanitized || peak_bytes() - before < kMostPeakBytes) << peak_bytes() - before;
}

}  // namespace
}  // namespace fanlight::test
