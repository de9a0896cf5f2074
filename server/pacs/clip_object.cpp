// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/clip_object.hpp"

#include "server/pacs/series_object.hpp"

#include <dcmtk/dcmdata/dcpixel.h>
#include <dcmtk/dcmdata/dcpixseq.h>
#include <dcmtk/dcmdata/dcpxitem.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <memory>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr std::uint32_t kColours = 3;

Error wrong_clip(std::string_view problem) {
  return {ErrorCode::kBadInput,
          fmt::format("{}, expected baseline JPEG files of one size for a clip", problem)};
}

unsigned word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return (static_cast<unsigned>(bytes[at]) << 8U) | bytes[at + 1];
}

/// Whether there is an end of the image; a few bytes may follow.
bool has_end(std::span<const std::uint8_t> jpeg) {
  constexpr std::array<std::uint8_t, 2> kEnd = {0xFF, 0xD9};
  constexpr std::size_t kMostAfter = 256;
  const auto tail = jpeg.last(std::min(jpeg.size(), kMostAfter));
  return !std::ranges::search(tail, kEnd).empty();
}

Result<Jpegs> read_files(std::span<const std::filesystem::path> files) {
  Jpegs jpegs;
  std::size_t bytes = 0;
  for (const std::filesystem::path& path : files) {
    const std::string name = printable(path.string());
    std::error_code problem;
    bytes += std::filesystem::file_size(path, problem);
    std::ifstream file(path, std::ios::binary);
    if (problem || !file)
      return Error{ErrorCode::kNotFound, fmt::format("{} cannot be read, expected a JPEG file", name)};
    if (bytes > kMostBytes) return wrong_clip(fmt::format("the files have over {} bytes", kMostBytes));
    jpegs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return jpegs;
}

/// `name_of`: of a JPEG by its index, for messages.
template <typename Name>
Result<JpegShape> common_shape(const Jpegs& jpegs, Name name_of) {
  JpegShape shape;
  for (std::size_t i = 0; i < jpegs.size(); ++i) {
    const auto found = jpeg_shape(jpegs[i]);
    if (!found) return Error{found.error().code, fmt::format("{}: {}", name_of(i), found.error().message)};
    if (i == 0) shape = *found;
    if (*found != shape) return wrong_clip(fmt::format("{} has another size than the first", name_of(i)));
  }
  return shape;
}

/// A basic offset table, and a fragment for each frame.
OFCondition put_frames(DcmDataset& dataset, const Jpegs& jpegs) {
  auto sequence = std::make_unique<DcmPixelSequence>(DcmTag(DCM_PixelData, EVR_OB));
  auto table = std::make_unique<DcmPixelItem>(DcmTag(DCM_PixelItemTag, EVR_OB));
  DcmPixelItem* const offsets = table.get();
  if (const OFCondition put = sequence->insert(table.release()); put.bad()) return put;
  DcmOffsetList starts;
  for (const std::vector<std::uint8_t>& jpeg : jpegs) {
    // DCMTK takes it as bytes that it may change, and copies them.
    auto* const bytes = const_cast<Uint8*>(jpeg.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    const OFCondition stored =
        sequence->storeCompressedFrame(starts, bytes, static_cast<Uint32>(jpeg.size()), 0);
    if (stored.bad()) return stored;
  }
  if (const OFCondition made = offsets->createOffsetTable(starts); made.bad()) return made;
  auto pixels = std::make_unique<DcmPixelData>(DCM_PixelData);
  pixels->putOriginalRepresentation(EXS_JPEGProcess1, nullptr, sequence.release());
  const OFCondition put = dataset.insert(pixels.get(), true);
  if (put.good()) (void)pixels.release();
  return put;
}

void add_clip(DicomFields& fields, const JpegShape& shape, std::size_t frames, double frames_per_second,
              double compression) {
  fields.text(DCM_NumberOfFrames, fmt::format("{}", frames));
  fields.tag(DCM_FrameIncrementPointer, DCM_FrameTime);
  fields.text(DCM_FrameTime, fmt::format("{:.6g}", 1000 / frames_per_second));
  fields.text(DCM_RecommendedDisplayFrameRate, fmt::format("{:.0f}", std::max(frames_per_second, 1.0)));
  fields.text(DCM_LossyImageCompression, "01");
  fields.text(DCM_LossyImageCompressionMethod, "ISO_10918_1");
  fields.text(DCM_LossyImageCompressionRatio, fmt::format("{:.2f}", compression));
  fields.whole(DCM_SamplesPerPixel, kColours);
  fields.text(DCM_PhotometricInterpretation, "YBR_FULL_422");
  fields.whole(DCM_PlanarConfiguration, 0);
  fields.whole(DCM_Rows, shape.height);
  fields.whole(DCM_Columns, shape.width);
  fields.whole(DCM_BitsAllocated, 8);
  fields.whole(DCM_BitsStored, 8);
  fields.whole(DCM_HighBit, 7);
  fields.whole(DCM_PixelRepresentation, 0);
}

Result<std::vector<std::uint8_t>> object_of(const Jpegs& jpegs, const JpegShape& shape,
                                            double frames_per_second, DicomSeries& series) {
  silence_dicom_log();
  std::size_t bytes = 0;
  constexpr std::size_t kItemBytes = 16;  // an item's head, a place in the offset table, a byte of padding
  for (const std::vector<std::uint8_t>& jpeg : jpegs) bytes += jpeg.size() + kItemBytes;
  const double plain =
      static_cast<double>(shape.width) * shape.height * kColours * static_cast<double>(jpegs.size());
  DcmFileFormat file;
  bool failed = false;
  DicomFields fields(*file.getDataset(), failed);
  begin_object(fields, UID_UltrasoundMultiframeImageStorage, series);
  add_clip(fields, shape, jpegs.size(), frames_per_second, plain / static_cast<double>(bytes));
  failed = put_frames(*file.getDataset(), jpegs).bad() || failed;
  return object_bytes(file, failed, EXS_JPEGProcess1, bytes);
}

Error no_clip() {
  return {ErrorCode::kInvalidArgument, "a clip has no frames or no rate, expected both"};
}

}  // namespace

Result<JpegShape> jpeg_shape(std::span<const std::uint8_t> jpeg) {
  constexpr unsigned kStart = 0xFFD8;
  constexpr unsigned kBaseline = 0xFFC0;
  constexpr unsigned kScan = 0xFFDA;
  if (jpeg.size() < 4 || word_at(jpeg, 0) != kStart) return wrong_clip("it is no JPEG");
  if (!has_end(jpeg)) return wrong_clip("it is cut off");
  for (std::size_t at = 2; at + 9 < jpeg.size();) {
    const unsigned marker = word_at(jpeg, at);
    if (marker == 0xFFFF) {  // a fill byte
      ++at;
      continue;
    }
    if (marker < 0xFF00 || marker == kScan) break;
    if (marker == kBaseline) {
      const JpegShape shape{
          .width = word_at(jpeg, at + 7), .height = word_at(jpeg, at + 5), .channels = jpeg[at + 9]};
      if (jpeg[at + 4] == 8 && shape.width > 0 && shape.height > 0 && shape.channels == kColours)
        return shape;
      return wrong_clip("it is not of 8 bits and three channels");
    }
    at += 2 + word_at(jpeg, at + 2);
  }
  return wrong_clip("it is not baseline JPEG");
}

Result<std::vector<std::uint8_t>> clip_object(std::span<const std::filesystem::path> files,
                                              double frames_per_second, DicomSeries& series) {
  if (files.empty() || !(frames_per_second > 0)) return no_clip();
  const auto jpegs = read_files(files);
  if (!jpegs) return jpegs.error();
  const auto shape = common_shape(*jpegs, [&](std::size_t i) { return printable(files[i].string()); });
  return shape ? object_of(*jpegs, *shape, frames_per_second, series) : shape.error();
}

Result<std::vector<std::uint8_t>> clip_object(const Jpegs& jpegs, double frames_per_second,
                                              DicomSeries& series) {
  if (jpegs.empty() || !(frames_per_second > 0)) return no_clip();
  const auto shape = common_shape(jpegs, [](std::size_t i) { return fmt::format("picture {}", i + 1); });
  return shape ? object_of(jpegs, *shape, frames_per_second, series) : shape.error();
}

}  // namespace fanlight
