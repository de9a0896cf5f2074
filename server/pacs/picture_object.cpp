// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/picture_object.hpp"

#include <fmt/format.h>

#include <fstream>
#include <string>
#include <string_view>

#include "proto/base/printable.hpp"
#include "proto/images/image_library.hpp"
#include "server/pacs/series_object.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kMostSide = 65'535;
constexpr std::size_t kChannels = 3;

void add_picture(DicomFields& fields, const PictureToSend& picture) {
  fields.text(DCM_ConversionType, "WSD");  // of a workstation
  const bool was_lossy = picture.lossy_ratio > 0;
  fields.text(DCM_LossyImageCompression, was_lossy ? "01" : "00");
  if (was_lossy) {
    fields.text(DCM_LossyImageCompressionRatio, fmt::format("{:.2f}", picture.lossy_ratio));
    fields.text(DCM_LossyImageCompressionMethod, picture.lossy_method);
  }
  fields.whole(DCM_SamplesPerPixel, kChannels);
  fields.text(DCM_PhotometricInterpretation, "RGB");
  fields.whole(DCM_PlanarConfiguration, 0);
  fields.whole(DCM_Rows, picture.height);
  fields.whole(DCM_Columns, picture.width);
  fields.whole(DCM_BitsAllocated, 8);
  fields.whole(DCM_BitsStored, 8);
  fields.whole(DCM_HighBit, 7);
  fields.whole(DCM_PixelRepresentation, 0);
  fields.bytes(DCM_PixelData, picture.rgb);
}

/// The formats of which it is known what they have lost.
enum class PictureFormat : std::uint8_t { kUnknown, kLossless, kJpeg };

PictureFormat format_of(const std::filesystem::path& path) {
  using namespace std::string_view_literals;
  std::string head(8, '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.starts_with("\xFF\xD8\xFF")) return PictureFormat::kJpeg;
  const bool is_pnm = head[0] == 'P' && head[1] >= '1' && head[1] <= '6';
  const bool is_lossless = is_pnm || head.starts_with("\x89PNG"sv) || head.starts_with("BM"sv);
  return is_lossless ? PictureFormat::kLossless : PictureFormat::kUnknown;
}

/// RGB of pixels with any number of channels, of 8 bits.
std::vector<std::uint8_t> rgb_of(std::span<const std::uint8_t> values, std::size_t channels) {
  const std::size_t pixels = values.size() / channels;
  const bool is_grey = channels < kChannels;
  const bool has_alpha = channels == 2 || channels == 4;
  std::vector<std::uint8_t> rgb(pixels * kChannels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    const auto of = values.subspan(pixel * channels, channels);
    const unsigned alpha = has_alpha ? of[channels - 1] : 255U;
    for (std::size_t channel = 0; channel < kChannels; ++channel)
      rgb[pixel * kChannels + channel] = static_cast<std::uint8_t>(of[is_grey ? 0 : channel] * alpha / 255U);
  }
  return rgb;
}

}  // namespace

Result<std::vector<std::uint8_t>> picture_object(const PictureToSend& picture, DicomSeries& series) {
  const std::size_t wanted = std::size_t{picture.width} * picture.height * kChannels;
  if (picture.width == 0 || picture.height == 0 || picture.width > kMostSide || picture.height > kMostSide ||
      picture.rgb.size() != wanted) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("a picture of {} x {} pixels in {} bytes does not fit, expected sides of 1 to {} and 3 "
                    "bytes a pixel",
                    picture.width, picture.height, picture.rgb.size(), kMostSide)};
  }
  silence_dicom_log();
  DcmFileFormat file;
  bool failed = false;
  DicomFields fields(*file.getDataset(), failed);
  begin_object(fields, UID_SecondaryCaptureImageStorage, series);
  add_picture(fields, picture);
  return object_bytes(file, failed, EXS_LittleEndianExplicit, picture.rgb.size());
}

Result<std::vector<std::uint8_t>> picture_file_object(const std::filesystem::path& path,
                                                      DicomSeries& series) {
  const std::string name = printable(path.string());
  const auto wrong = [&](std::string_view problem) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: {}, expected a picture: PNG, JPEG, BMP or PNM", name, problem)};
  };
  const PictureFormat format = format_of(path);
  if (format == PictureFormat::kUnknown) {
    return Error{
        ErrorCode::kBadInput,
        fmt::format("{} is neither a picture nor DICOM, expected a picture (PNG, JPEG, BMP, PNM) or a "
                    "DICOM file",
                    name)};
  }
  const auto library = image_library();
  if (!library) return library.error();
  const auto reader = (*library)->open(path.string());
  if (!reader) return wrong(printable(reader.error().message));
  const ImageShape shape = (*reader)->shape();
  const bool fits = shape.width > 0 && shape.height > 0 && shape.depth == 1 && shape.channels >= 1 &&
                    shape.channels <= 4 && shape.width <= 16'384 && shape.height <= 16'384;
  if (!fits) {
    return wrong(
        fmt::format("it has {} x {} x {} pixels of {} channels, and at most 16384 x 16384 of 4 are sent",
                    shape.width, shape.height, shape.depth, shape.channels));
  }
  const auto channels = static_cast<std::size_t>(shape.channels);
  std::vector<std::uint8_t> values(static_cast<std::size_t>(shape.width) *
                                   static_cast<std::size_t>(shape.height) * channels);
  if (auto read = (*reader)->read(1, values); !read) return wrong(printable(read.error().message));
  const std::vector<std::uint8_t> rgb = rgb_of(values, channels);
  double jpeg_ratio = 0;
  if (format == PictureFormat::kJpeg) {
    std::error_code gone;
    const auto bytes = std::filesystem::file_size(path, gone);
    if (gone) return wrong(gone.message());
    jpeg_ratio = static_cast<double>(values.size()) / static_cast<double>(bytes);
  }
  return picture_object({.width = static_cast<std::uint32_t>(shape.width),
                         .height = static_cast<std::uint32_t>(shape.height),
                         .rgb = rgb,
                         .lossy_ratio = jpeg_ratio},
                        series);
}

}  // namespace fanlight
