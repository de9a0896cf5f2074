// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/foreign_format.hpp"

#include <algorithm>
#include <cctype>
#include <string>

namespace fanlight {

namespace {

constexpr std::string_view kConvertSequence =
    "a PLUS sequence (.igs.mha) of 8 or 16 bit frames with their angles; Fanlight does not convert it";
constexpr std::string_view kCartesian =
    "the volume as NRRD (.nrrd), MetaImage (.mha) or DICOM (.dcm), or the frames that it was made from as a "
    "PLUS "
    "sequence (.igs.mha)";
constexpr std::string_view kSingle =
    "a series of them, given as a pattern such as frame.%04d.png or as their folder";
constexpr std::string_view kVideo =
    "its frames as numbered pictures, such as ffmpeg -i FILE frame.%04d.png makes";

struct Magic {
  std::size_t offset;
  std::string_view bytes;
  ForeignFormat format;
};

using namespace std::string_view_literals;

constexpr Magic kMagics[] = {
    {344, "ni1\0"sv, {"the header of a NIfTI volume, whose voxels are in another file", kCartesian}},
    {4, "n+2\0"sv, {"a NIfTI-2 volume", kCartesian}},
    {0, "<VTKFile"sv, {"a VTK file", kCartesian}},
    {0, "<?xml"sv, {"an XML file, such as a VTK volume (.vti)", kCartesian}},
    {0, "# vtk DataFile"sv, {"a VTK file", kCartesian}},
    {0, "II*\0"sv, {"a TIFF picture", kSingle}},
    {0, "MM\0*"sv, {"a TIFF picture", kSingle}},
    {0, "\x89PNG"sv, {"a PNG picture", kSingle}},
    {0, "\xFF\xD8\xFF"sv, {"a JPEG picture", kSingle}},
    {0, "BM"sv, {"a BMP picture", kSingle}},
    {128, "DICM"sv, {"a DICOM file", "a program that was built with DCMTK (FANLIGHT_DICOM=ON)"}},
    {4, "ftyp"sv, {"an MP4 video", kVideo}},
    {0, "RIFF"sv, {"an AVI video", kVideo}},
    {0, "\x1A\x45\xDF\xA3"sv, {"a Matroska video", kVideo}},
    {0, "\x89HDF"sv, {"an HDF5 file", kConvertSequence}},
    {0, "\x1F\x8B"sv, {"a file compressed with gzip", "the file unpacked (gunzip)"}},
    {0, "PK\x03\x04"sv, {"a ZIP archive", "a file from it, unpacked"}},
    {0, "MATLAB"sv, {"a MATLAB file", kConvertSequence}},
};

struct Extension {
  std::string_view end;
  ForeignFormat format;
};

// Formats without a signature, or with one that is not public.
constexpr Extension kExtensions[] = {
    {".imf", {"an ImFusion file", kConvertSequence}},
    {".raw", {"raw pixels without a header", kConvertSequence}},
    {".rf",
     {"lines of radio frequency",
      "brightness frames of 8 or 16 bit made of them, as a PLUS sequence (.igs.mha)"}},
};

}  // namespace

std::optional<ForeignFormat> foreign_format(std::span<const unsigned char> first_bytes,
                                            const std::filesystem::path& path) {
  const std::string_view bytes(reinterpret_cast<const char*>(first_bytes.data()), first_bytes.size());
  const std::string ending = path.filename().string();
  for (const Magic& magic : kMagics) {
    if (bytes.size() >= magic.offset + magic.bytes.size() &&
        bytes.substr(magic.offset, magic.bytes.size()) == magic.bytes)
      return magic.format;
  }
  // Whatever its name is: a header of text is read, and what is wrong with it is reported with its line.
  if (bytes.starts_with("NRRD000") || bytes.starts_with("KRETZFILE") || bytes.starts_with("ObjectType") ||
      bytes.starts_with("NDims") || bytes.starts_with("Comment"))
    return std::nullopt;
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  const auto named =
      std::ranges::find_if(kExtensions, [&](const Extension& each) { return name.ends_with(each.end); });
  if (named != std::end(kExtensions)) return named->format;
  const auto text = bytes.substr(0, bytes.find('\n'));
  const bool is_text =
      std::ranges::all_of(text, [](char c) { return (c >= ' ' && c < 0x7F) || c == '\t' || c == '\r'; });
  if (!bytes.empty() && !is_text) return ForeignFormat{"no file of a known kind", kConvertSequence};
  return std::nullopt;
}

}  // namespace fanlight
