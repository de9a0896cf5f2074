// SPDX-License-Identifier: Apache-2.0
// Stills of displays become DICOM objects in a queue.
// DCMTK's headers come first.
#include <dcmtk/config/osconfig.h>

#include <dcmtk/dcmdata/dctk.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <queue>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/convert/grid_volume.hpp"
#include "server/codec/jpeg_coder.hpp"
#include "server/codec/png_coder.hpp"
#include "server/codec/png_reader.hpp"
#include "server/pacs/still_queue.hpp"
#include "server/pacs/still_request.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;

/// RFC 4648, section 4.
std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    unsigned group = 0;
    for (std::size_t i = 0; i < 3; ++i) group = group << 8U | (at + i < bytes.size() ? bytes[at + i] : 0U);
    for (std::size_t i = 0; i < 4; ++i)
      text += at + i > bytes.size() ? '=' : kDigits[group >> (18 - 6 * i) & 63U];
  }
  return text;
}

/// A picture of `width` x 2 pixels in base64, whose first pixel is red, and the others (1, 2, 3).
std::string png(std::uint32_t width) {
  std::vector<std::uint8_t> rgba;
  for (std::uint32_t pixel = 0; pixel < 2 * width; ++pixel) {
    const std::array<std::uint8_t, 4> colour =
        pixel == 0 ? std::array<std::uint8_t, 4>{255, 0, 0, 255} : std::array<std::uint8_t, 4>{1, 2, 3, 255};
    rgba.insert(rgba.end(), colour.begin(), colour.end());
  }
  PngCoder coder;
  const auto coded = coder.encode({.width = width, .height = 2, .rgba = rgba}, true);
  return base64(coded->bytes);
}

std::vector<std::uint8_t> jpeg(std::uint32_t width, std::uint8_t grey) {
  const std::vector<std::uint8_t> rgba(std::size_t{4} * width * width, grey);
  JpegCoder coder(90);
  const auto coded = coder.encode({.width = width, .height = width, .rgba = rgba}, true);
  return {coded->bytes.begin(), coded->bytes.end()};
}

std::string request(const json& patient, const std::string& picture = png(3)) {
  return json{{"png", picture}, {"patient", patient}}.dump();
}

TEST(StillRequest, HasAPictureAndAPatient) {
  // Files of other sizes, which end in one, two or no "=".
  for (const std::uint32_t width : {3, 4, 5, 64}) {
    const auto parsed = parse_picture_request(request({{"patient_id", "P1"}}, png(width)));
    ASSERT_TRUE(parsed) << parsed.error().message;
    const auto* const still = std::get_if<StillRequest>(&*parsed);
    ASSERT_NE(still, nullptr);
    EXPECT_EQ(still->patient.patient_id, "P1");
    EXPECT_EQ(still->picture.width, width);
    EXPECT_EQ(still->picture.height, 2U);
    EXPECT_EQ((std::vector<std::uint8_t>(still->picture.rgb.begin(), still->picture.rgb.begin() + 6)),
              (std::vector<std::uint8_t>{255, 0, 0, 1, 2, 3}));
  }
}

/// A chunk of a PNG file, with its checksum.
std::string chunk(const std::string& type, const std::string& data) {
  const auto bytes = [](std::uint32_t value) {
    return std::string{static_cast<char>(value >> 24U), static_cast<char>(value >> 16U & 255U),
                       static_cast<char>(value >> 8U & 255U), static_cast<char>(value & 255U)};
  };
  const std::string checked = type + data;
  const auto sum =
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return bytes(static_cast<std::uint32_t>(data.size())) + checked + bytes(static_cast<std::uint32_t>(sum));
}

TEST(PngReader, UnpacksNothingButPixels) {
  std::vector<std::uint8_t> rgba(4 * 4, 255);
  PngCoder coder;
  const auto coded = coder.encode({.width = 2, .height = 2, .rgba = rgba}, true);
  std::string file(coded->bytes.begin(), coded->bytes.end());
  // 8 MB of zeros in a text of 8 KB, two hundred times: libpng alone would hold 1.6 GB.
  std::string zeros(8'000'000, '\0');
  std::string packed(compressBound(zeros.size()), '\0');
  uLongf size = packed.size();
  ASSERT_EQ(compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                      reinterpret_cast<const Bytef*>(zeros.data()), zeros.size(), 9),
            Z_OK);
  const std::string text = chunk("zTXt", std::string("k\0\0", 3) + packed.substr(0, size));
  constexpr std::size_t kAfterHeader = 8 + 25;
  for (int i = 0; i < 200; ++i) file.insert(kAfterHeader, text);
  rusage before{};
  getrusage(RUSAGE_SELF, &before);
  const auto read = read_png({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()});
  rusage after{};
  getrusage(RUSAGE_SELF, &after);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->rgb, std::vector<std::uint8_t>(12, 255));
  constexpr long kMostKb = 100'000;
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, kMostKb);
}

TEST(PngReader, RefusesWhatIsTooLargeOrCut) {
  std::vector<std::uint8_t> rgba(std::size_t{4} * (kMostPngSide + 1), 255);
  PngCoder coder;
  const auto coded = coder.encode({.width = kMostPngSide + 1, .height = 1, .rgba = rgba}, true);
  const auto large = read_png(coded->bytes);
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("at most 4096"), std::string::npos);
  for (std::size_t bytes = 0; bytes < coded->bytes.size(); ++bytes)
    EXPECT_FALSE(read_png(coded->bytes.first(bytes)));
}

TEST(StillRequest, RefusesOthersAndDoesNotRepeatThem) {
  const json patient = {{"patient_id", "Secret"}};
  const std::string cut = png(3).substr(0, 40);
  for (const std::string& body : {std::string(),
                                  std::string("{"),
                                  std::string("[]"),
                                  json{{"patient", patient}}.dump(),
                                  json{{"png", png(3)}}.dump(),
                                  json{{"png", 3}, {"patient", patient}}.dump(),
                                  json{{"png", png(3)}, {"patient", patient}, {"more", 1}}.dump(),
                                  request(json::object()),
                                  request({{"patient_id", ""}}),
                                  request({{"patient_id", "  "}}),
                                  request({{"patient_name", "^^ ="}}),
                                  request({{"patient_id", "1"}, {"birth_date", "19900231"}}),
                                  request({{"birth_date", "Secret"}, {"patient_id", "1"}}),
                                  request(patient, ""),
                                  request(patient, "===="),
                                  request(patient, "Secret!!"),
                                  request(patient, "AAA"),
                                  request(patient, "AAAA"),
                                  request(patient, cut),
                                  request({{"Secret", "1"}, {"patient_id", "1"}})}) {
    const auto still = parse_picture_request(body);
    ASSERT_FALSE(still) << body.substr(0, 80);
    EXPECT_NE(still.error().code, ErrorCode::kUnavailable);
    EXPECT_NE(still.error().message.find("expected"), std::string::npos) << still.error().message;
    EXPECT_EQ(still.error().message.find("Secret"), std::string::npos) << still.error().message;
  }
}

class StillQueueTest : public testing::Test {
 protected:
  void open() {
    auto opened = open_still_queue(folder_ / "queue", [this](std::function<void()> work) {
      const std::scoped_lock lock(mutex_);
      posted_.push(std::move(work));
      changed_.notify_one();
    });
    ASSERT_TRUE(opened) << opened.error().message;
    queue_ = *std::move(opened);
  }

  /// Adds a still, and waits for its result.
  Result<void> add(const std::string& body) {
    Result<void> result = Error{ErrorCode::kBroken, "not called"};
    queue_->add(body, [&](const Result<ArchivedObject>& added) {
      result = added ? Result<void>() : added.error();
      if (added) kind_ = *added;
    });
    run_posted();
    return result;
  }

  void run_posted() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !posted_.empty(); });
    const auto work = std::move(posted_.front());
    posted_.pop();
    lock.unlock();
    work();
  }

  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "queue"))
      found.push_back(entry.path());
    std::ranges::sort(found);
    return found;
  }

  static std::string text_of(const std::filesystem::path& path, const DcmTagKey& tag) {
    DcmFileFormat file;
    OFString text;
    EXPECT_TRUE(file.loadFile(path.c_str()).good());
    EXPECT_TRUE(file.getDataset()->findAndGetOFString(tag, text).good());
    return text.c_str();
  }

  ArchivedObject kind_{};  // of the last one that was added
  TemporaryFolder folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::queue<std::function<void()>> posted_;
  std::unique_ptr<StillArchive> queue_;  // last: it ends first
};

TEST_F(StillQueueTest, StillsOfAPatientAreOneSeries) {
  open();
  const json first = {{"patient_id", "P1"}, {"patient_name", "Doe^Jane"}};
  ASSERT_TRUE(add(request(first)));
  ASSERT_TRUE(add(request(first)));
  ASSERT_TRUE(add(request({{"patient_id", "P2"}})));
  EXPECT_EQ(queue_->report().waiting, 3U);
  const auto found = files();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(text_of(found[0], DCM_PatientName), "Doe^Jane");
  EXPECT_EQ(text_of(found[0], DCM_SOPClassUID), UID_SecondaryCaptureImageStorage);
  EXPECT_EQ(text_of(found[0], DCM_SeriesInstanceUID), text_of(found[1], DCM_SeriesInstanceUID));
  EXPECT_EQ(text_of(found[0], DCM_StudyInstanceUID), text_of(found[1], DCM_StudyInstanceUID));
  EXPECT_EQ(text_of(found[0], DCM_StudyTime), text_of(found[1], DCM_StudyTime));
  EXPECT_EQ(text_of(found[1], DCM_InstanceNumber), "2");
  EXPECT_NE(text_of(found[0], DCM_StudyInstanceUID), text_of(found[2], DCM_StudyInstanceUID));
  for (const auto& path : found) EXPECT_EQ(path.string().find("Doe"), std::string::npos);
}

TEST_F(StillQueueTest, AVolumeIsOfTheStudyOfThePatientsStills) {
  open();
  const json patient = {{"patient_id", "P1"}, {"patient_name", "Doe^Jane"}};
  ASSERT_TRUE(add(request(patient)));
  const double step_rad = 0.05;
  const std::vector<double> angles_rad = {-step_rad, 0, step_rad};
  const auto volume = std::make_shared<const Volume>(
      made_volume(kSmallFan, angles_rad, [](const Point& at) { return at.y_mm > 40 ? 150 : 5; }));
  const std::string body = json{{"volume", "shown"}, {"patient", patient}}.dump();
  Result<ArchivedObject> result = Error{ErrorCode::kBroken, "not called"};
  queue_->add_volume({.volume = volume, .acquired_utc_s = 86'400}, body,
                     [&](const Result<ArchivedObject>& added) { result = added; });
  run_posted();
  ASSERT_TRUE(result) << result.error().message;
  const auto found = files();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(text_of(found[1], DCM_SOPClassUID), UID_EnhancedUSVolumeStorage);
  EXPECT_EQ(text_of(found[1], DCM_PatientName), "Doe^Jane");
  EXPECT_EQ(text_of(found[1], DCM_AcquisitionDateTime), "19700102000000");
  for (const DcmTagKey& same : {DCM_StudyInstanceUID, DCM_StudyDate, DCM_StudyTime})
    EXPECT_EQ(text_of(found[0], same), text_of(found[1], same)) << same.toString();
  EXPECT_NE(text_of(found[0], DCM_SeriesInstanceUID), text_of(found[1], DCM_SeriesInstanceUID));
  const auto grid = scan_converted(*volume, usual_spacing_mm(*volume), [](double) { return true; });
  ASSERT_TRUE(grid);
  DcmFileFormat file;
  const Uint8* voxels = nullptr;
  unsigned long bytes = 0;
  ASSERT_TRUE(file.loadFile(found[1].c_str()).good());
  ASSERT_TRUE(file.getDataset()->findAndGetUint8Array(DCM_PixelData, voxels, &bytes).good());
  ASSERT_GE(bytes, grid->voxels.size());  // an even number
  EXPECT_TRUE(std::equal(grid->voxels.begin(), grid->voxels.end(), voxels));

  for (const json& wrong : {json({{"volume", 1}}), json({{"volume", 1}, {"patient", {{"sex", "F"}}}}),
                            json({{"volume", 1}, {"patient", patient}, {"png", ""}})}) {
    EXPECT_FALSE(queue_->check_volume_request(wrong.dump())) << wrong;
    queue_->add_volume({.volume = volume}, wrong.dump(),
                       [&](const Result<ArchivedObject>& added) { result = added; });
    run_posted();
    EXPECT_FALSE(result) << wrong;
  }
  EXPECT_EQ(files().size(), 2U);
}

TEST_F(StillQueueTest, AClipHasItsPicturesAsTheyAre) {
  open();
  const json patient = {{"patient_id", "P1"}};
  const std::vector<std::uint8_t> first = jpeg(16, 10);
  const std::vector<std::uint8_t> second = jpeg(16, 200);
  const json body = {
      {"jpegs", {base64(first), base64(second)}}, {"pictures_per_second", 8}, {"patient", patient}};
  ASSERT_TRUE(add(body.dump()));
  EXPECT_EQ(kind_, ArchivedObject::kClip);
  ASSERT_TRUE(add(request(patient)));
  EXPECT_EQ(kind_, ArchivedObject::kStill);
  const auto found = files();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(text_of(found[0], DCM_SOPClassUID), UID_UltrasoundMultiframeImageStorage);
  EXPECT_EQ(text_of(found[0], DCM_NumberOfFrames), "2");
  EXPECT_EQ(text_of(found[0], DCM_FrameTime), "125");
  EXPECT_EQ(text_of(found[0], DCM_SeriesInstanceUID), text_of(found[1], DCM_SeriesInstanceUID));
  std::ifstream file(found[0], std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (const auto& each : {first, second})
    EXPECT_NE(bytes.find(std::string(each.begin(), each.end())), std::string::npos);

  const auto refused = [&](const char* key, const json& value, const char* expected) {
    json wrong = body;
    wrong[key] = value;
    const auto added = add(wrong.dump());
    ASSERT_FALSE(added) << wrong;
    EXPECT_NE(added.error().message.find(expected), std::string::npos) << added.error().message;
  };
  refused("pictures_per_second", 0, "0.1 to 60");
  refused("pictures_per_second", 61, "0.1 to 60");
  refused("pictures_per_second", "8", "0.1 to 60");
  refused("jpegs", json::array(), "no frames");
  refused("jpegs", json(std::vector<std::string>(2000)), "in place of");
  refused("jpegs", {1}, "base64");
  refused("jpegs", {base64(first), "AAAA"}, "picture 2: it is no JPEG");
  const std::span cut(first.data(), first.size() - 3);
  refused("jpegs", {base64(first), base64(cut)}, "picture 2: it is cut off");
  refused("jpegs", {base64(first), base64(jpeg(8, 10))}, "picture 2 has another size");
  refused("jpegs", "", "in place of");
  refused("png", png(3), "in place of");
  EXPECT_EQ(files().size(), 2U);
}

TEST_F(StillQueueTest, APatientWhoComesBackKeepsTheStudy) {
  open();
  for (const char* id : {"P1", "P2", "P1"}) ASSERT_TRUE(add(request({{"patient_id", id}})));
  const auto found = files();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(text_of(found[0], DCM_StudyInstanceUID), text_of(found[2], DCM_StudyInstanceUID));
  EXPECT_EQ(text_of(found[2], DCM_InstanceNumber), "2");
}

TEST_F(StillQueueTest, SaysWhetherThePictureHasLostSomething) {
  open();
  json body = json::parse(request({{"patient_id", "P1"}}));
  ASSERT_TRUE(add(body.dump()));
  body["lossy"] = {{"method", "h264"}, {"ratio", 21.5}};
  ASSERT_TRUE(add(body.dump()));
  for (const json& wrong :
       {json("jpeg"), json({{"method", "jpeg"}}), json({{"method", "gif"}, {"ratio", 2}}),
        json({{"method", "jpeg"}, {"ratio", 0}}), json({{"method", "jpeg"}, {"ratio", "2"}}),
        json({{"method", "jpeg"}, {"ratio", 1e300}})}) {
    body["lossy"] = wrong;
    EXPECT_FALSE(add(body.dump())) << wrong;
  }
  const auto found = files();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(text_of(found[0], DCM_LossyImageCompression), "00");
  EXPECT_EQ(text_of(found[1], DCM_LossyImageCompression), "01");
  EXPECT_EQ(text_of(found[1], DCM_LossyImageCompressionRatio), "21.50");
  EXPECT_EQ(text_of(found[1], DCM_LossyImageCompressionMethod), "ISO_14496_10");
}

TEST_F(StillQueueTest, StillsOfAnOrderAreOfItsStudy) {
  open();
  ASSERT_TRUE(add(request({{"patient_id", "P1"}, {"study_uid", "1.2.3.4"}, {"accession_number", "A7"}})));
  const auto found = files();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(text_of(found[0], DCM_StudyInstanceUID), "1.2.3.4");
  EXPECT_EQ(text_of(found[0], DCM_AccessionNumber), "A7");
}

TEST_F(StillQueueTest, SaysWhatCannotBeWritten) {
  open();
  std::filesystem::remove_all(folder_ / "queue");
  const auto added = add(request({{"patient_id", "P1"}}));
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE(queue_->report().available);
}

TEST_F(StillQueueTest, WritesWhatItHasBeforeItEnds) {
  open();
  for (int i = 0; i < 5; ++i)
    queue_->add(request({{"patient_id", "P1"}}), [](const Result<ArchivedObject>&) {});
  queue_.reset();
  EXPECT_EQ(files().size(), 5U);
}

TEST_F(StillQueueTest, RefusesAFolderThatIsOpenToEveryone) {
  const auto path = folder_ / "queue";
  std::filesystem::create_directory(path);
  std::filesystem::permissions(path, std::filesystem::perms::all);
  const auto opened = open_still_queue(path, [](const std::function<void()>&) {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace fanlight::test
