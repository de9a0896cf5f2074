// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/nifti_file.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string_view>
#include <type_traits>

#include "acquisition/replay/inflater.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

using namespace std::string_view_literals;

constexpr std::size_t kNiftiHeaderBytes = 348;
constexpr std::size_t kMagicAt = 344;
constexpr std::string_view kNiftiMagic = "n+1\0"sv;
constexpr std::string_view kOwnDescription = "Fanlight, axes of the transducer";

struct GzCloser {
  void operator()(gzFile file) const { gzclose(file); }
};
/// Plain files too: zlib reads them as they are.
using GzFile = std::unique_ptr<std::remove_pointer_t<gzFile>, GzCloser>;

struct NiftiType {
  int code;
  PixelFormat format;
};
constexpr NiftiType kNiftiTypes[] = {
    {2, {.bytes = 1}},
    {256, {.bytes = 1, .is_signed = true}},
    {4, {.bytes = 2, .is_signed = true}},
    {512, {.bytes = 2}},
};

/// The fields of nifti_1_header, by their offsets.
class NiftiHeader {
 public:
  using Bytes = std::array<unsigned char, kNiftiHeaderBytes>;

  explicit NiftiHeader(const Bytes& bytes) : bytes_(bytes) {
    swapped_ = number<std::int32_t>(0) != static_cast<std::int32_t>(kNiftiHeaderBytes);
  }

  bool is_valid() const {
    return number<std::int32_t>(0) == static_cast<std::int32_t>(kNiftiHeaderBytes) &&
           std::memcmp(bytes_.data() + kMagicAt, kNiftiMagic.data(), kNiftiMagic.size()) == 0;
  }
  bool big_endian() const { return swapped_ != (std::endian::native == std::endian::big); }

  template <typename T>
  T number(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), bytes_.data() + offset, sizeof(T));
    if (swapped_) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }

  int dim(std::size_t index) const { return number<std::int16_t>(40 + 2 * index); }
  double pixdim(std::size_t index) const { return number<float>(76 + 4 * index); }
  int datatype() const { return number<std::int16_t>(70); }
  double vox_offset() const { return number<float>(108); }
  double slope() const { return number<float>(112); }
  double intercept() const { return number<float>(116); }
  int units() const { return bytes_[123]; }
  std::string_view description() const { return {reinterpret_cast<const char*>(bytes_.data()) + 148, 80}; }
  int qform_code() const { return number<std::int16_t>(252); }
  int sform_code() const { return number<std::int16_t>(254); }
  double srow(std::size_t row, std::size_t column) const {
    return number<float>(280 + 16 * row + 4 * column);
  }

 private:
  Bytes bytes_;
  bool swapped_ = false;
};

/// mm in a unit of length, nullopt: not known.
std::optional<double> mm_of(int units) {
  switch (units & 7) {
    case 1:
      return 1000;
    case 2:
      return 1;
    case 3:
      return 0.001;
    default:
      return std::nullopt;
  }
}

/// Seconds in a unit of time; 0: no time.
double seconds_of(int units) {
  switch (units & 56) {
    case 8:
      return 1;
    case 16:
      return 1e-3;
    case 24:
      return 1e-6;
    default:
      return 0;
  }
}

class NiftiReader {
 public:
  NiftiReader(const std::filesystem::path& path, std::uint64_t max_bytes)
      : path_(path), name_(shown(path)), max_bytes_(max_bytes) {}

  Result<NiftiVolumes> read() {
    file_.reset(gzopen(path_.c_str(), "rb"));
    std::error_code failure;
    const std::uint64_t file_bytes = std::filesystem::file_size(path_, failure);
    if (file_ == nullptr || failure)
      return bad("the file cannot be opened", "one that this user may read", ErrorCode::kUnavailable);
    NiftiHeader::Bytes bytes{};
    const int got = gzread(file_.get(), bytes.data(), bytes.size());
    if (got < 0) return bad("its compressed bytes are damaged or cut off", "a whole NIfTI file");
    if (got != static_cast<int>(bytes.size()))
      return bad("the file ends in its header of 348 bytes", "a whole NIfTI file");
    const NiftiHeader header(bytes);
    if (!header.is_valid()) return bad("it has no header of NIfTI-1", "\"n+1\" at byte 344");
    if (auto taken = take_sizes(header); !taken) return taken.error();
    if (auto taken = take_axes(header); !taken) return taken.error();
    if (auto fits = check(volumes_.grid, name_); !fits) return fits.error();
    if (auto taken = take_values(header); !taken) return taken.error();
    if (auto taken = read_voxels(header, file_bytes); !taken) return taken.error();
    return std::move(volumes_);
  }

 private:
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return {code, fmt::format("{}: {}, expected {}", name_, wrong, expected)};
  }

  Result<void> take_sizes(const NiftiHeader& header) {
    const int axes = header.dim(0);
    if (axes < 3 || axes > 7)
      return bad(fmt::format("it has {} axes", axes), "three, or four with time", ErrorCode::kUnsupported);
    for (int axis = 1; axis <= axes; ++axis) {
      const int size = header.dim(static_cast<std::size_t>(axis));
      if (size < 1) return bad(fmt::format("axis {} has {} voxels", axis, size), "1 to 32767");
      if (axis > 4 && size > 1)
        return bad(fmt::format("it has {} axes", axes), "three, or four with time", ErrorCode::kUnsupported);
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
      volumes_.grid.size[axis] = static_cast<std::uint32_t>(header.dim(axis + 1));
    volumes_.grid.volumes = axes > 3 ? static_cast<std::uint32_t>(header.dim(4)) : 1;
    const double step_s = header.pixdim(4) * seconds_of(header.units());
    if (volumes_.grid.volumes > 1 && std::isfinite(step_s) && step_s > 0)
      for (std::uint32_t i = 0; i < volumes_.grid.volumes; ++i)
        volumes_.grid.volume_times_s.push_back(i * step_s);
    return {};
  }

  /// Methods 3, 2 and 1 of nifti1.h.
  Result<void> take_axes(const NiftiHeader& header) {
    const std::optional<double> unit_mm = mm_of(header.units());
    const double mm = unit_mm.value_or(1);
    if (!unit_mm) volumes_.notes.emplace_back("Its unit of length is not given: mm are assumed.");
    VoxelGrid& grid = volumes_.grid;
    if (header.sform_code() > 0) {
      std::array<std::array<double, 3>, 3> axes{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t row = 0; row < 3; ++row) axes[axis][row] = mm * header.srow(row, axis);
      const auto found = orthogonal(axes);
      if (!found)
        return bad("the axes of its sform do not stand at right angles", "a grid of right angles",
                   ErrorCode::kUnsupported);
      grid.spacing_mm = found->lengths;
      grid.is_left_handed = found->is_left_handed;
      // Of our own: x and y are negated, since NIfTI's point to the right and to the front.
      if (header.description().starts_with(kOwnDescription) && !grid.is_left_handed)
        grid.origin_mm = {-mm * header.srow(0, 3), -mm * header.srow(1, 3), mm * header.srow(2, 3)};
      return {};
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
      grid.spacing_mm[axis] = mm * std::abs(header.pixdim(axis + 1));
    grid.is_left_handed = header.qform_code() > 0 && header.pixdim(0) < 0;
    if (header.qform_code() <= 0)
      volumes_.notes.emplace_back("It says nothing about its axes: they are taken to be right-handed.");
    return {};
  }

  Result<void> take_values(const NiftiHeader& header) {
    const auto* const type = std::ranges::find(kNiftiTypes, header.datatype(), &NiftiType::code);
    if (type == std::end(kNiftiTypes)) {
      return bad(fmt::format("its values are of the type {}", header.datatype()),
                 "whole numbers of 8 or 16 bit (2, 4, 256 or 512)", ErrorCode::kUnsupported);
    }
    volumes_.format = type->format;
    volumes_.format.big_endian = type->format.bytes == 2 && header.big_endian();
    const bool scaled = std::isfinite(header.slope()) && std::isfinite(header.intercept()) &&
                        header.slope() != 0 && (header.slope() != 1 || header.intercept() != 0);
    if (scaled && header.slope() < 0)
      return bad("a larger value is a weaker echo (scl_slope is negative)", "values that rise with the echo",
                 ErrorCode::kUnsupported);
    if (scaled) {
      volumes_.notes.push_back(fmt::format(
          "Its slope of {:.4g} and offset of {:.4g} are not used: the window of grey levels is that "
          "of the stored values.",
          header.slope(), header.intercept()));
    }
    return {};
  }

  Result<void> read_voxels(const NiftiHeader& header, std::uint64_t file_bytes) {
    const std::uint64_t bytes = volumes_.grid.voxels() * volumes_.grid.volumes * volumes_.format.bytes;
    const double offset = header.vox_offset();
    if (!(offset >= static_cast<double>(kNiftiHeaderBytes) && offset <= 1e9))
      return bad(fmt::format("its voxels begin at byte {}", offset), "352 or more");
    const bool packed = gzdirect(file_.get()) == 0;
    const std::uint64_t most = packed ? file_bytes * kMostInflation : file_bytes;
    if (bytes > max_bytes_)
      return bad(fmt::format("it has {} bytes of voxels", bytes), fmt::format("at most {}", max_bytes_));
    const auto skipped = static_cast<std::uint64_t>(offset);
    if (skipped + bytes > most) {
      return bad(fmt::format("a file of {} bytes cannot hold its {} bytes of voxels", file_bytes, bytes),
                 "a whole file");
    }
    if (gzseek(file_.get(), static_cast<z_off_t>(skipped), SEEK_SET) < 0)
      return bad("the file ends before its voxels", "a whole file");
    try {
      volumes_.voxels.resize(bytes);
    } catch (const std::bad_alloc&) {
      return bad(fmt::format("its voxels need {} bytes", bytes), "as much free memory",
                 ErrorCode::kUnavailable);
    }
    constexpr std::uint64_t kMostAtOnce = 1 << 28;
    for (std::uint64_t read = 0; read < bytes;) {
      const auto wanted = static_cast<unsigned>(std::min(bytes - read, kMostAtOnce));
      const int got = gzread(file_.get(), volumes_.voxels.data() + read, wanted);
      if (got <= 0) return damaged(read, bytes);
      read += static_cast<std::uint64_t>(got);
    }
    // The checksum stands behind the last voxel.
    std::array<unsigned char, 4096> rest{};
    constexpr int kMostRest = 16;
    int got = packed ? 1 : 0;
    for (int i = 0; got > 0 && i < kMostRest; ++i) got = gzread(file_.get(), rest.data(), rest.size());
    if (got > 0) return bad("there are many more bytes behind its voxels", "the end of the file");
    const int closed = gzclose(file_.release());
    if (got < 0 || (packed && closed != Z_OK)) return damaged(bytes, bytes);
    return {};
  }

  Error damaged(std::uint64_t read, std::uint64_t bytes) const {
    return bad(fmt::format("its voxels are damaged or cut off after {} bytes", read),
               fmt::format("{} bytes", bytes));
  }

  const std::filesystem::path& path_;
  std::string name_;
  std::uint64_t max_bytes_;
  GzFile file_;
  NiftiVolumes volumes_;
};

}  // namespace

bool is_nifti(const std::filesystem::path& path, std::span<const unsigned char> first_bytes) {
  const std::string_view text(reinterpret_cast<const char*>(first_bytes.data()), first_bytes.size());
  if (text.size() >= kNiftiHeaderBytes && text.substr(kMagicAt, kNiftiMagic.size()) == kNiftiMagic)
    return true;
  const std::string name = path.string();
  return !text.empty() && (name.ends_with(".nii") || name.ends_with(".nii.gz"));
}

Result<NiftiVolumes> read_nifti(const std::filesystem::path& path, std::uint64_t max_bytes) {
  return NiftiReader(path, max_bytes).read();
}

}  // namespace fanlight
