// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/dicom_file.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "acquisition/replay/dicom_fields.hpp"
#include "acquisition/replay/dicom_nesting.hpp"
#include "acquisition/replay/dicom_pixels.hpp"
#include "acquisition/replay/dicom_planes.hpp"
#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/replay/inflater.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

using dicom::bad;
using dicom::text_of;
using dicom::whole_of;

namespace {

constexpr std::size_t kMagicOffset = 128;
constexpr std::string_view kMagic = "DICM";

}  // namespace

void prepare_dicom_library() {
  static const bool prepared = [] {
    silence_dicom_log();  // what matters is in our own messages
    DcmRLEDecoderRegistration::registerCodecs();
    DJDecoderRegistration::registerCodecs();
    DJLSDecoderRegistration::registerCodecs();
    return true;
  }();
  (void)prepared;
}

namespace {

/// The calibrated part of the picture (PS3.3 C.8.5.5, US Region Calibration).
struct Region {
  Crop crop;
  FrameSequence::PixelSize pixel_size;
  bool is_negative = false;  ///< one of the two is a negative number in the file
};

std::optional<Region> region_in(DcmItem& item, const SampleLayout& layout) {
  constexpr std::uint32_t kTwoDimensional = 1;
  constexpr std::uint32_t kTissue = 1;
  constexpr std::uint32_t kCentimetres = 3;
  constexpr double kMmInCm = 10;
  const bool is_tissue = whole_of(item, DCM_RegionSpatialFormat, 0) == kTwoDimensional &&
                         whole_of(item, DCM_RegionDataType, 0) == kTissue &&
                         whole_of(item, DCM_PhysicalUnitsXDirection, 0) == kCentimetres &&
                         whole_of(item, DCM_PhysicalUnitsYDirection, 0) == kCentimetres;
  Float64 across_cm = 0;
  Float64 down_cm = 0;
  Uint32 left = 0;
  Uint32 top = 0;
  Uint32 right = 0;
  Uint32 bottom = 0;
  const bool whole = item.findAndGetFloat64(DCM_PhysicalDeltaX, across_cm).good() &&
                     item.findAndGetFloat64(DCM_PhysicalDeltaY, down_cm).good() &&
                     item.findAndGetUint32(DCM_RegionLocationMinX0, left).good() &&
                     item.findAndGetUint32(DCM_RegionLocationMinY0, top).good() &&
                     item.findAndGetUint32(DCM_RegionLocationMaxX1, right).good() &&
                     item.findAndGetUint32(DCM_RegionLocationMaxY1, bottom).good();
  // Some scanners give the first column and row behind it.
  right = std::min<Uint32>(right, layout.columns - 1);
  bottom = std::min<Uint32>(bottom, layout.rows - 1);
  const bool inside = whole && right > left && bottom > top;
  if (!is_tissue || !inside || !(std::abs(across_cm) > 0) || !(std::abs(down_cm) > 0)) return std::nullopt;
  return Region{
      .crop = {.left = left, .top = top, .columns = right - left + 1, .rows = bottom - top + 1},
      .pixel_size = {.width_mm = std::abs(across_cm) * kMmInCm, .height_mm = std::abs(down_cm) * kMmInCm},
      .is_negative = across_cm < 0 || down_cm < 0};
}

/// The largest region of 2D tissue.
std::optional<Region> region_of(DcmItem& dataset, const SampleLayout& layout) {
  DcmSequenceOfItems* regions = nullptr;
  if (dataset.findAndGetSequence(DCM_SequenceOfUltrasoundRegions, regions).bad() || regions == nullptr)
    return {};
  std::optional<Region> largest;
  const auto pixels = [](const Region& of) { return std::uint64_t{of.crop.columns} * of.crop.rows; };
  constexpr unsigned long kMostRegions = 64;
  for (unsigned long i = 0; i < std::min(regions->card(), kMostRegions); ++i) {
    const auto region = region_in(*regions->getItem(i), layout);
    if (region && (!largest || pixels(*region) > pixels(*largest))) largest = region;
  }
  return largest;
}

struct OpenedFile {
  std::unique_ptr<DcmFileFormat> file;
  bool is_volume = false;
};

Result<OpenedFile> open_file(const std::filesystem::path& path, const std::string& name) {
  if (auto fits = check_dicom_nesting(path, name); !fits) return fits.error();
  auto file = std::make_unique<DcmFileFormat>();
  constexpr std::string_view kForm = "a DICOM file that is whole";
  const OFCondition loaded = file->loadFile(path.c_str());
  if (loaded.bad())
    return bad(name, fmt::format("the DICOM file cannot be read ({})", in_quotes(loaded.text())), kForm);
  const std::string kind = text_of(*file->getDataset(), DCM_SOPClassUID);
  const bool is_volume = kind == UID_EnhancedUSVolumeStorage;
  const bool is_multiframe = kind == UID_UltrasoundMultiframeImageStorage ||
                             kind == UID_RETIRED_UltrasoundMultiframeImageStorage ||
                             kind == UID_MultiframeGrayscaleByteSecondaryCaptureImageStorage ||
                             kind == UID_MultiframeTrueColorSecondaryCaptureImageStorage;
  if (!is_volume && !is_multiframe) {
    const char* const known = dcmFindNameOfUID(kind.c_str());
    return bad(name,
               fmt::format("this DICOM file is {}", known != nullptr ? std::string(known) : in_quotes(kind)),
               "an ultrasound multi-frame image or an Enhanced US Volume", ErrorCode::kUnsupported);
  }
  return OpenedFile{.file = std::move(file), .is_volume = is_volume};
}

/// Whether the file can hold as many frames, before memory is taken for them.
Result<void> check_presence(const std::filesystem::path& path, DcmDataset& dataset,
                            const SampleLayout& layout, std::uint64_t frames, bool is_volume,
                            const std::string& name) {
  DcmElement* pixels = nullptr;
  if (dataset.findAndGetElement(DCM_PixelData, pixels).bad() || pixels == nullptr)
    return bad(name, "the DICOM file has no pixels", "Pixel Data");
  const std::uint64_t wanted = frames * layout.frame_bytes();
  std::error_code failure;
  const std::uint64_t bytes = std::filesystem::file_size(path, failure);
  // A compressed frame is an item of 8 bytes at least; what it unfolds to is read frame by frame. A grid is
  // read whole.
  constexpr std::uint64_t kItemBytes = 8;
  const bool fits = layout.is_compressed
                        ? frames * kItemBytes <= bytes && (!is_volume || wanted <= kMostInflation * bytes)
                        : wanted <= pixels->getLength();
  if (fits) return {};
  return bad(name, fmt::format("its pixels do not match the {} frames of its header", frames),
             fmt::format("{} bytes of them", wanted));
}

/// "0\\50\\49": milliseconds since the frame before, of as many frames. False: it is another text.
bool take_times(std::string_view text, std::vector<SequenceFrame>& frames) {
  constexpr double kMsInS = 1000;
  double time_s = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string_view word = text.substr(0, text.find('\\'));
    const auto step_ms = number_in<double>(trimmed(word));
    if (!step_ms || *step_ms < 0) return false;
    if (i > 0) time_s += *step_ms / kMsInS;
    frames[i].timestamp_s = time_s;
    if (word.size() == text.size()) return i + 1 == frames.size();
    text.remove_prefix(word.size() + 1);
  }
  return false;
}

/// Frame Time Vector, Frame Time or a rate; none where the file has none.
void add_times(DcmItem& dataset, std::vector<SequenceFrame>& frames) {
  constexpr double kMsInS = 1000;
  const auto even = [&frames](double step_s) {
    if (!(step_s > 0 && step_s < 1000)) return false;
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i].timestamp_s = step_s * static_cast<double>(i);
    return true;
  };
  // As it stands: the library reads the text from its beginning for each value.
  const char* vector = nullptr;
  if (dataset.findAndGetString(DCM_FrameTimeVector, vector).good() && vector != nullptr &&
      take_times(vector, frames))
    return;
  Float64 value = 0;
  if (dataset.findAndGetFloat64(DCM_FrameTime, value).good() && even(value / kMsInS)) return;
  Sint32 rate_hz = 0;
  for (const DcmTagKey& key : {DCM_CineRate, DCM_RecommendedDisplayFrameRate}) {
    if (dataset.findAndGetSint32(key, rate_hz).good() && rate_hz > 0 && even(1.0 / rate_hz)) return;
  }
}

/// Poses and times of planes that turn; the fit of the fan takes them.
void add_planes(const std::vector<DicomPlane>& planes, FrameSequence& sequence) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const std::size_t before = i > 0 && planes[i - 1].volume == planes[i].volume
                                   ? *sequence.frames[i - 1].frame_index + std::size_t{1}
                                   : 0;
    SequenceFrame& frame = sequence.frames[i];
    frame.pose = planes[i].pose;
    frame.volume_index = planes[i].volume;
    frame.frame_index = static_cast<std::uint32_t>(before);
    frame.timestamp_s = planes[i].time_s.value_or(0) + kAssumedFrameS * static_cast<double>(before);
  }
  const ImagePose& pose = planes.front().pose;
  sequence.pixel_size = {.width_mm = std::hypot(pose[0], pose[4], pose[8]),
                         .height_mm = std::hypot(pose[1], pose[5], pose[9])};
  sequence.pixel_size_origin = "its Pixel Spacing";
  sequence.notes.push_back(
      fmt::format("The planes have no times: {} s for each is assumed.", kAssumedFrameS));
}

}  // namespace

bool is_dicom(std::span<const unsigned char> first_bytes) {
  return first_bytes.size() >= kMagicOffset + kMagic.size() &&
         std::memcmp(first_bytes.data() + kMagicOffset, kMagic.data(), kMagic.size()) == 0;
}

Result<DicomFile> open_dicom(const std::filesystem::path& path, std::uint64_t max_bytes) {
  prepare_dicom_library();
  const std::string name = shown(path);
  auto opened = open_file(path, name);
  if (!opened) return opened.error();
  DcmDataset& dataset = *opened->file->getDataset();
  const auto layout = dicom_layout(dataset, name);
  if (!layout) return layout.error();
  Sint32 count = 1;
  (void)dataset.findAndGetSint32(DCM_NumberOfFrames, count);
  const std::uint64_t frame_bytes = layout->frame_bytes();
  if (count < 1 || count > static_cast<Sint32>(FrameFields::kMostFrames) ||
      frame_bytes * static_cast<std::uint64_t>(count) > max_bytes) {
    return bad(
        name, fmt::format("it has {} frames of {} bytes", count, frame_bytes),
        fmt::format("1 to {} frames, of at most {} bytes in all", FrameFields::kMostFrames, max_bytes));
  }
  if (auto there =
          check_presence(path, dataset, *layout, static_cast<std::uint64_t>(count), opened->is_volume, name);
      !there)
    return there.error();
  std::vector<std::uint32_t> frames(static_cast<std::size_t>(count));
  std::iota(frames.begin(), frames.end(), 0);
  DicomFile result;
  FrameSequence& sequence = result.sequence;
  sequence.format = layout->format();
  sequence.compressed = layout->is_compressed;
  Crop crop{.columns = layout->columns, .rows = layout->rows};
  if (opened->is_volume) {
    const auto planes = dicom_planes(dataset, static_cast<std::uint32_t>(count), name);
    if (!planes) return planes.error();
    const ImagePose transducer = volume_to_transducer(dataset).value_or(ImagePose{});
    auto grid = grid_of(*planes, layout->columns, layout->rows, transducer, name);
    if (!grid) return grid.error();
    result.grid = *std::move(grid);
    frames.clear();
    for (const DicomPlane& plane : *planes) frames.push_back(plane.frame);
    sequence.frames.resize(frames.size());
    if (!result.grid) add_planes(*planes, sequence);
  } else {
    sequence.frames.resize(frames.size());
    add_times(dataset, sequence.frames);
    if (const auto region = region_of(dataset, *layout)) {
      crop = region->crop;
      sequence.pixel_size = region->pixel_size;
      sequence.pixel_size_origin = "its calibrated region";
      sequence.notes.push_back(fmt::format(
          "The frames are the region of the DICOM picture that is calibrated as tissue: {} x {} pixels from "
          "column {} and row {} on.",
          crop.columns, crop.rows, crop.left, crop.top));
      if (region->is_negative) {
        sequence.notes.emplace_back(
            "A size of its pixels, PhysicalDeltaX or PhysicalDeltaY, is negative: the amount is used, and "
            "the "
            "picture is read as it is stored, with the first row next to the probe.");
      }
    }
  }
  sequence.columns = crop.columns;
  sequence.rows = crop.rows;
  auto reader = dicom_reader(name, std::move(opened->file), *layout, crop, std::move(frames));
  if (!reader) return reader.error();
  result.reader = *std::move(reader);
  return result;
}

}  // namespace fanlight
