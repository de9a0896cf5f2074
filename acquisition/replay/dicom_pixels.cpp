// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/dicom_pixels.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcfcache.h>
#include <dcmtk/dcmdata/dctk.h>
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "acquisition/replay/dicom_fields.hpp"
#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

using dicom::bad;
using dicom::text_of;
using dicom::whole_of;

namespace {

/// Two pixels share their colours: Y Y Cb Cr.
bool halves_colours(std::string_view colours) {
  return colours == "YBR_FULL_422" || colours == "YBR_PARTIAL_422";
}

/// Reads the frames that are wanted, as grey values, cut to the region.
class DicomReader : public FrameReader {
 public:
  DicomReader(std::string name, std::unique_ptr<DcmFileFormat> file, DcmElement& pixels, SampleLayout layout,
              Crop crop, std::vector<std::uint32_t> frames)
      : name_(std::move(name)),
        file_(std::move(file)),
        pixels_(pixels),
        layout_(std::move(layout)),
        crop_(crop),
        frames_(std::move(frames)) {
    const std::size_t bytes = pixel_count() * layout_.samples * layout_.allocated_bytes;
    stored_.resize(bytes + bytes % 2);  // of an even size, as the library demands
  }

  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to) override {
    OFString colours = layout_.colours.c_str();
    const OFCondition read = read_stored(frames_[frame], colours);
    if (read.bad()) {
      return bad(name_, fmt::format("frame {} cannot be read ({})", frames_[frame], in_quotes(read.text())),
                 "a whole file, plain or compressed as RLE, JPEG or JPEG-LS");
    }
    for (std::uint32_t row = 0; row < crop_.rows; ++row) {
      const std::size_t first = std::size_t{crop_.top + row} * layout_.columns + crop_.left;
      std::uint8_t* const line = to.data() + std::size_t{row} * crop_.columns * layout_.allocated_bytes;
      if (layout_.samples == 3) {
        read_colour(first, colours, line);
      } else if (layout_.allocated_bytes == 2) {
        read_grey<std::uint16_t>(first, line);
      } else {
        read_grey<std::uint8_t>(first, line);
      }
    }
    return {};
  }

 private:
  OFCondition read_stored(std::uint32_t frame, OFString& colours) {
    if (layout_.is_compressed) {
      // In order the library continues at the fragment behind the last one; 0 makes it look for it.
      if (frame != next_frame_) next_fragment_ = 0;
      next_frame_ = frame + 1;
      const OFCondition read =
          pixels_.getUncompressedFrame(file_->getDataset(), frame, next_fragment_, stored_.data(),
                                       static_cast<Uint32>(stored_.size()), colours, &cache_);
      if (read.bad()) next_fragment_ = 0;
      return read;
    }
    const std::uint64_t place = layout_.frame_bytes() * frame;
    if (place > std::numeric_limits<Uint32>::max()) return EC_IllegalCall;
    return pixels_.getPartialValue(stored_.data(), static_cast<Uint32>(place),
                                   static_cast<Uint32>(layout_.frame_bytes()), &cache_);
  }

  std::size_t pixel_count() const { return std::size_t{layout_.columns} * layout_.rows; }

  template <typename T>
  void read_grey(std::size_t first, std::uint8_t* line) const {
    const std::uint32_t mask = (1U << layout_.stored_bits) - 1;
    const std::uint32_t sign = layout_.is_signed ? 1U << (layout_.stored_bits - 1) : 0;
    for (std::uint32_t column = 0; column < crop_.columns; ++column) {
      T stored = 0;
      std::memcpy(&stored, stored_.data() + (first + column) * sizeof(T), sizeof(T));
      std::uint32_t value = std::uint32_t{stored} >> layout_.lowest_bit & mask;
      // From the highest value down to the lowest; of a signed one the complement is its mirror image.
      if (layout_.is_inverted) value = ~value & mask;
      const auto grey = static_cast<T>((value ^ sign) - sign);
      std::memcpy(line + column * sizeof(T), &grey, sizeof(T));
    }
  }

  void read_colour(std::size_t first, const OFString& colours, std::uint8_t* line) const {
    const std::uint8_t* const from = stored_.data();
    const std::size_t plane = pixel_count();
    const bool is_rgb = colours == "RGB";
    // A decoder gives each pixel its own colours.
    const bool halved = !layout_.is_compressed && halves_colours(layout_.colours);
    for (std::uint32_t column = 0; column < crop_.columns; ++column) {
      const std::size_t pixel = first + column;
      if (!is_rgb) {
        line[column] = halved ? from[pixel / 2 * 4 + pixel % 2] : from[layout_.is_planar ? pixel : 3 * pixel];
        continue;
      }
      const std::size_t red = layout_.is_planar ? pixel : 3 * pixel;
      const std::size_t next = layout_.is_planar ? plane : 1;
      line[column] = static_cast<std::uint8_t>(
          std::lround(0.299 * from[red] + 0.587 * from[red + next] + 0.114 * from[red + 2 * next]));
    }
  }

  std::string name_;
  std::unique_ptr<DcmFileFormat> file_;
  DcmElement& pixels_;
  SampleLayout layout_;
  Crop crop_;
  std::vector<std::uint32_t> frames_;  // numbers in the file
  std::vector<std::uint8_t> stored_;   // a frame
  DcmFileCache cache_;
  std::uint32_t next_frame_ = 0;
  Uint32 next_fragment_ = 0;
};

}  // namespace

PixelFormat SampleLayout::format() const {
  return {.bytes = allocated_bytes,
          .is_signed = is_signed,
          .big_endian = allocated_bytes == 2 && std::endian::native == std::endian::big};
}

std::uint64_t SampleLayout::frame_bytes() const {
  const std::uint64_t pixels = std::uint64_t{columns} * rows;
  return halves_colours(colours) ? 2 * pixels : pixels * samples * allocated_bytes;
}

Result<SampleLayout> dicom_layout(DcmDataset& dataset, const std::string& name) {
  SampleLayout layout{.columns = whole_of(dataset, DCM_Columns, 0),
                      .rows = whole_of(dataset, DCM_Rows, 0),
                      .samples = whole_of(dataset, DCM_SamplesPerPixel, 1),
                      .colours = text_of(dataset, DCM_PhotometricInterpretation)};
  const std::uint32_t allocated = whole_of(dataset, DCM_BitsAllocated, 8);
  layout.allocated_bytes = allocated / 8;
  layout.stored_bits = whole_of(dataset, DCM_BitsStored, allocated);
  const std::uint32_t high_bit = whole_of(dataset, DCM_HighBit, layout.stored_bits - 1);
  layout.is_signed = whole_of(dataset, DCM_PixelRepresentation, 0) == 1;
  layout.is_planar = whole_of(dataset, DCM_PlanarConfiguration, 0) == 1;
  layout.is_inverted = layout.colours == "MONOCHROME1";
  const auto side = [](std::uint32_t pixels) { return pixels >= 2 && pixels <= FrameFields::kMostSide; };
  if (!side(layout.columns) || !side(layout.rows)) {
    return bad(name, fmt::format("its frames have {} x {} pixels", layout.columns, layout.rows),
               fmt::format("2 to {} on each side", FrameFields::kMostSide));
  }
  const bool grey = layout.samples == 1 && layout.colours.starts_with("MONOCHROME");
  const bool colour = layout.samples == 3 && allocated == 8 &&
                      (layout.colours == "RGB" || layout.colours.starts_with("YBR_"));
  if (!grey && !colour) {
    return bad(name,
               fmt::format("its pixels are {} with {} samples of {} bit", in_quotes(layout.colours),
                           layout.samples, allocated),
               "MONOCHROME1 or 2, RGB or YBR", ErrorCode::kUnsupported);
  }
  const bool bits = (allocated == 8 || allocated == 16) && layout.stored_bits >= 2 &&
                    layout.stored_bits <= allocated && high_bit < allocated &&
                    high_bit + 1 >= layout.stored_bits;
  if (!bits) {
    return bad(name,
               fmt::format("{} of {} bits are stored, up to bit {}", layout.stored_bits, allocated, high_bit),
               "8 or 16 bit", ErrorCode::kUnsupported);
  }
  layout.lowest_bit = high_bit + 1 - layout.stored_bits;
  const E_TransferSyntax syntax = dataset.getOriginalXfer();
  layout.is_compressed = syntax != EXS_LittleEndianImplicit && syntax != EXS_LittleEndianExplicit &&
                         syntax != EXS_BigEndianExplicit;
  return layout;
}

Result<std::unique_ptr<FrameReader>> dicom_reader(const std::string& name,
                                                  std::unique_ptr<DcmFileFormat> file,
                                                  const SampleLayout& layout, const Crop& crop,
                                                  std::vector<std::uint32_t> frames) {
  DcmElement* pixels = nullptr;
  if (file->getDataset()->findAndGetElement(DCM_PixelData, pixels).bad() || pixels == nullptr)
    return bad(name, "the DICOM file has no pixels", "Pixel Data");
  return std::unique_ptr<FrameReader>(
      std::make_unique<DicomReader>(name, std::move(file), *pixels, layout, crop, std::move(frames)));
}

}  // namespace fanlight
