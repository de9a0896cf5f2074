// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/voxel_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/replay/grid_padding.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

// The largest that a fan may have: planes that are almost parallel.
constexpr double kAxisMm = 1000;  // above the probe's face
constexpr double kMostSideMm = 500;

/// The centre of the first voxel in the transducer frame.
std::array<double, 3> origin_of(const VoxelGrid& grid) {
  if (grid.origin_mm) return *grid.origin_mm;
  const auto half_mm = [&grid](std::size_t axis) {
    return (grid.size[axis] - 1.0) * grid.spacing_mm[axis] / 2;
  };
  return {-half_mm(0), 0, -half_mm(2)};
}

/// The fan around a grid: its frames cover the face of the grid that is nearest to the axis.
struct Fan {
  std::array<double, 3> origin_mm;
  double first_mm = 0;  // from the axis to the first rows of the grid
  double first_rad = 0;
  double last_rad = 0;
  std::uint32_t frames = 0;
  double row_mm = 0;
  std::uint32_t rows = 0;

  explicit Fan(const VoxelGrid& grid) : origin_mm(origin_of(grid)), first_mm(kAxisMm + origin_mm[1]) {
    const double depth_mm = (grid.size[1] - 1) * grid.spacing_mm[1];
    const double width_mm = (grid.size[2] - 1) * grid.spacing_mm[2];
    first_rad = std::atan(origin_mm[2] / first_mm);
    last_rad = std::atan((origin_mm[2] + width_mm) / first_mm);
    // Furthest from the axis the frames stand as far apart as the slices.
    const double steps = (last_rad - first_rad) * (first_mm + depth_mm) / grid.spacing_mm[2];
    frames = static_cast<std::uint32_t>(std::ceil(steps)) + 1;
    const double widest_rad = std::max(std::abs(first_rad), std::abs(last_rad));
    const double reach_mm = (first_mm + depth_mm) / std::cos(widest_rad) - first_mm;
    row_mm = std::max(grid.spacing_mm[1], reach_mm / (FrameFields::kMostSide - 1));
    rows = static_cast<std::uint32_t>(std::floor(reach_mm / row_mm)) + 1;
  }

  double angle_rad(std::uint64_t frame) const {
    return std::lerp(first_rad, last_rad, static_cast<double>(frame) / (frames - 1));
  }
};

/// A place between two neighbours along an axis.
struct Between {
  std::uint32_t first = 0;
  double share = 0;  // of the second

  Between(double at, std::uint32_t size) {
    const double inside = std::clamp(at, 0.0, size - 1.0);
    first = std::min(static_cast<std::uint32_t>(inside), size - 2);
    share = inside - first;
  }
};

template <typename T>
class FanReader : public FrameReader {
 public:
  FanReader(const VoxelGrid& grid, bool swapped, std::vector<std::uint8_t> stored)
      : grid_(grid),
        fan_(grid),
        swapped_(swapped),
        stored_(std::move(stored)),
        voxels_(reinterpret_cast<T*>(stored_.data()), stored_.size() / sizeof(T)),
        line_(grid.size[0]) {
    if (swapped_) {
      for (T& voxel : voxels_) voxel = other_order(voxel);
    }
    outside_ = *std::ranges::min_element(voxels_);
  }

  UnscannedPixels mark_unscanned(Unscanned wanted) override;

  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to) override {
    const double angle_rad = fan_.angle_rad(frame % fan_.frames);
    const T* const volume = voxels_.data() + frame / fan_.frames * grid_.voxels();
    for (std::uint32_t row = 0; row < fan_.rows; ++row) {
      read_row(volume, fan_.first_mm + row * fan_.row_mm, angle_rad);
      if (grid_.is_left_handed) std::ranges::reverse(line_);
      if (swapped_) std::ranges::transform(line_, line_.begin(), other_order);
      const std::size_t bytes = line_.size() * sizeof(T);
      std::memcpy(to.data() + row * bytes, line_.data(), bytes);
    }
    return {};
  }

 private:
  using Look = GridPadding::Look;

  /// What most voxels on the faces of the first volume have.
  T value_on_faces() const;
  /// Whether the first volume has fluid besides the padding. Tissue alone may be a body in fluid without an
  /// echo.
  bool has_dark_parts(const std::vector<std::uint8_t>& padding) const;
  static std::string note_on(const GridPadding& padding, T value, bool is_left_out);

  static T other_order(T value) {
    const std::uint16_t bits = static_cast<std::make_unsigned_t<T>>(value);
    return sizeof(T) == 1 ? value : static_cast<T>(static_cast<std::uint16_t>(bits << 8 | bits >> 8));
  }

  void read_row(const T* volume, double from_axis_mm, double angle_rad) {
    const double slice = (from_axis_mm * std::sin(angle_rad) - fan_.origin_mm[2]) / grid_.spacing_mm[2];
    if (slice < -0.5 || slice > grid_.size[2] - 0.5) {  // outside the grid
      std::ranges::fill(line_, outside_);
      return;
    }
    // Above and below it the voxels of its faces are repeated, so that no false step shows there.
    const Between down((from_axis_mm * std::cos(angle_rad) - fan_.first_mm) / grid_.spacing_mm[1],
                       grid_.size[1]);
    const Between across(slice, grid_.size[2]);
    const std::size_t columns = grid_.size[0];
    const std::size_t to_slice = columns * grid_.size[1];
    const std::size_t first = across.first * to_slice + down.first * columns;
    const T* const upper = volume + first;
    const T* const lower = upper + columns;
    for (std::size_t i = 0; i < columns; ++i) {
      const double here = std::lerp(double{1} * upper[i], double{1} * lower[i], down.share);
      const double next =
          std::lerp(double{1} * upper[i + to_slice], double{1} * lower[i + to_slice], down.share);
      line_[i] = static_cast<T>(std::lround(std::lerp(here, next, across.share)));
    }
    if (!unscanned_.empty()) mark_row(first, down.share, across.share);
  }

  /// Gives a row the padding's value where voxels that were not scanned contribute to it, and nowhere else.
  void mark_row(std::size_t first, double down, double across) {
    const std::size_t columns = grid_.size[0];
    const std::size_t to_slice = columns * grid_.size[1];
    const auto add = [&](std::size_t from, double weight) {
      if (weight <= 0) return;
      for (std::size_t i = 0; i < columns; ++i) in_padding_[i] |= unscanned_[from + i];
    };
    std::ranges::fill(in_padding_, std::uint8_t{0});
    add(first, (1 - down) * (1 - across));
    add(first + columns, down * (1 - across));
    add(first + to_slice, (1 - down) * across);
    add(first + to_slice + columns, down * across);
    for (std::size_t i = 0; i < columns; ++i) {
      if (in_padding_[i] != 0) {
        line_[i] = outside_;
      } else if (line_[i] == outside_) {
        line_[i] = beside(outside_);
      }
    }
  }

  static T beside(T value) {
    return static_cast<T>(value == std::numeric_limits<T>::max() ? value - 1 : value + 1);
  }

  VoxelGrid grid_;
  Fan fan_;
  bool swapped_;
  std::vector<std::uint8_t> stored_;
  std::span<T> voxels_;  // in this machine's byte order
  std::vector<T> line_;
  T outside_{};                           // what was not scanned, or lies outside the grid
  std::vector<std::uint8_t> unscanned_;   // 1 for a voxel that was not scanned; empty: all were
  std::vector<std::uint8_t> in_padding_;  // of a row
};

template <typename T>
T FanReader<T>::value_on_faces() const {
  constexpr std::size_t kCodes = std::size_t{1} << (8 * sizeof(T));
  std::vector<std::uint32_t> counts(kCodes);
  const std::array<std::size_t, 3> size{grid_.size[0], grid_.size[1], grid_.size[2]};
  const auto count = [&](std::size_t x, std::size_t y, std::size_t z) {
    ++counts[static_cast<std::make_unsigned_t<T>>(voxels_[(z * size[1] + y) * size[0] + x])];
  };
  for (std::size_t z = 0; z < size[2]; ++z) {
    for (std::size_t y = 0; y < size[1]; ++y) {
      const bool is_face = z == 0 || z + 1 == size[2] || y == 0 || y + 1 == size[1];
      const std::size_t step = is_face ? 1 : size[0] - 1;
      for (std::size_t x = 0; x < size[0]; x += step) count(x, y, z);
    }
  }
  return static_cast<T>(std::ranges::max_element(counts) - counts.begin());
}

template <typename T>
UnscannedPixels FanReader<T>::mark_unscanned(Unscanned wanted) {
  const T value = value_on_faces();
  // What has the value in all volumes.
  std::vector<std::uint8_t> is_value(grid_.voxels(), 1);
  for (std::uint32_t volume = 0; volume < grid_.volumes; ++volume) {
    const T* const from = voxels_.data() + volume * grid_.voxels();
    for (std::size_t at = 0; at < is_value.size(); ++at) is_value[at] &= from[at] == value ? 1 : 0;
  }
  GridPadding padding = find_padding(grid_.size, std::move(is_value));
  const bool is_forced = wanted == Unscanned::kZero && padding.share > 0;
  if (padding.look == Look::kNone && !is_forced) return {};
  const bool is_left_out = is_forced || (padding.look == Look::kBorder && has_dark_parts(padding.voxels));
  UnscannedPixels found{.code = {}, .note = note_on(padding, value, is_left_out)};
  if (!is_left_out) return found;
  unscanned_ = std::move(padding.voxels);
  in_padding_.resize(line_.size());
  outside_ = value;
  found.code = static_cast<std::make_unsigned_t<T>>(value);
  return found;
}

template <typename T>
bool FanReader<T>::has_dark_parts(const std::vector<std::uint8_t>& padding) const {
  constexpr std::size_t kSide = 5;  // of a block: means even speckle out
  constexpr double kBlocks = 20'000;
  constexpr double kDarkShare = 0.4;  // of the way to the bright blocks
  constexpr double kLeastDark = 0.02;
  const std::array<std::size_t, 3> size{grid_.size[0], grid_.size[1], grid_.size[2]};
  double black = std::numeric_limits<T>::max();
  for (std::size_t voxel = 0; voxel < padding.size(); ++voxel)
    if (padding[voxel] == 0) black = std::min(black, double{1} * voxels_[voxel]);
  const auto step =
      static_cast<std::size_t>(std::max(1.0, std::cbrt(static_cast<double>(grid_.voxels()) / kBlocks)));
  std::vector<double> means;
  for (std::size_t z = 0; z + kSide <= size[2]; z += step) {
    for (std::size_t y = 0; y + kSide <= size[1]; y += step) {
      for (std::size_t x = 0; x + kSide <= size[0]; x += step) {
        double sum = 0;
        bool is_scanned = true;
        for (std::size_t at = 0; at < kSide * kSide * kSide && is_scanned; ++at) {
          const std::size_t voxel =
              ((z + at / (kSide * kSide)) * size[1] + y + at / kSide % kSide) * size[0] + x + at % kSide;
          is_scanned = padding[voxel] == 0;
          sum += voxels_[voxel];
        }
        if (is_scanned) means.push_back(sum / (kSide * kSide * kSide) - black);
      }
    }
  }
  if (means.empty()) return false;
  const auto bright = means.begin() + static_cast<std::ptrdiff_t>(means.size() * 9 / 10);
  std::ranges::nth_element(means, bright);
  const double most = kDarkShare * *bright;
  const auto dark = std::ranges::count_if(means, [most](double mean) { return mean <= most; });
  return static_cast<double>(dark) >= kLeastDark * static_cast<double>(means.size());
}

template <typename T>
std::string FanReader<T>::note_on(const GridPadding& padding, T value, bool is_left_out) {
  const std::string what = fmt::format("{:.0f} % of the volume, {} throughout and up to its border,",
                                       100 * padding.share, static_cast<int>(value));
  if (!is_left_out) {
    return what +
           " may be fluid or not scanned. It is taken for fluid; with unscanned = \"zero\" in the geometry "
           "its border is no surface.";
  }
  return what +
         " was not scanned: its border is no surface. With unscanned = \"none\" in the geometry it is fluid.";
}

}  // namespace

std::optional<AxisVectors> orthogonal(const std::array<std::array<double, 3>, 3>& axes) {
  constexpr double kMostCosine = 0.02;  // about a degree
  AxisVectors found;
  for (std::size_t axis = 0; axis < 3; ++axis)
    found.lengths[axis] = std::hypot(axes[axis][0], axes[axis][1], axes[axis][2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t other = (axis + 1) % 3;
    double product = 0;
    for (std::size_t i = 0; i < 3; ++i) product += axes[axis][i] * axes[other][i];
    const double lengths = found.lengths[axis] * found.lengths[other];
    // Negated, so that a NaN fails too.
    if (!(lengths > 0 && std::abs(product) <= kMostCosine * lengths)) return std::nullopt;
  }
  double determinant = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    determinant += axes[0][i] * (axes[1][j] * axes[2][k] - axes[1][k] * axes[2][j]);
  }
  found.is_left_handed = determinant < 0;
  return found;
}

Result<void> check(const VoxelGrid& grid, const std::string& name) {
  const auto bad = [&name](const std::string& wrong, const std::string& expected) {
    return Error{ErrorCode::kUnsupported, fmt::format("{}: {}, expected {}", name, wrong, expected)};
  };
  const std::array<double, 3> origin_mm = origin_of(grid);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double side_mm = (grid.size[axis] - 1.0) * grid.spacing_mm[axis];
    const bool fits = grid.size[axis] >= 2 && grid.size[axis] <= FrameFields::kMostSide &&
                      grid.spacing_mm[axis] >= 0.001 && grid.spacing_mm[axis] <= 10 && side_mm <= kMostSideMm;
    if (!fits) {
      return bad(
          fmt::format("a side of the volume has {} voxels of {} mm", grid.size[axis], grid.spacing_mm[axis]),
          fmt::format("2 to {} of 0.001 to 10 mm, and at most {} mm in all", FrameFields::kMostSide,
                      kMostSideMm));
    }
    if (!(std::abs(origin_mm[axis]) <= kMostSideMm)) {
      return bad(fmt::format("the volume lies {} mm away from the probe", origin_mm[axis]),
                 fmt::format("at most {} mm", kMostSideMm));
    }
  }
  if (grid.volumes < 1) return bad("there is no volume", "one at least");
  constexpr double kMostGrowth = 8;
  constexpr double kSmall = 1e6;  // voxels
  const Fan fan(grid);
  const double wanted = 1.0 * grid.size[0] * fan.rows * fan.frames;
  if (std::uint64_t{fan.frames} * grid.volumes > FrameFields::kMostFrames) {
    return bad(fmt::format("{} volumes of {} planes", grid.volumes, fan.frames),
               fmt::format("at most {} planes", FrameFields::kMostFrames));
  }
  if (fan.rows > FrameFields::kMostSide ||
      (wanted > kMostGrowth * static_cast<double>(grid.voxels()) && wanted > kSmall)) {
    return bad(fmt::format("a volume of {:.3g} x {:.3g} x {:.3g} mm would be {} planes of {} rows",
                           (grid.size[0] - 1) * grid.spacing_mm[0], (grid.size[1] - 1) * grid.spacing_mm[1],
                           (grid.size[2] - 1) * grid.spacing_mm[2], fan.frames, fan.rows),
               "a volume that is deeper, or less wide in elevation");
  }
  return {};
}

FrameSequence fan_through(const VoxelGrid& grid, PixelFormat format) {
  const Fan fan(grid);
  FrameSequence sequence;
  sequence.columns = grid.size[0];
  sequence.rows = fan.rows;
  sequence.format = format;
  sequence.is_grid = true;
  const auto field = [&sequence](std::string_view name, const auto& value) {
    sequence.fanlight_fields.emplace(name, fmt::format("{}", value));
  };
  field("FanlightFrameKind", kFrameKindNames[static_cast<std::size_t>(FrameKind::kCartesian)]);
  field("FanlightPixelWidthMm", grid.spacing_mm[0]);
  field("FanlightPixelHeightMm", fan.row_mm);
  field("FanlightFaceColumn", -fan.origin_mm[0] / grid.spacing_mm[0]);
  field("FanlightFaceRow", -fan.origin_mm[1] / fan.row_mm);
  field("FanlightMotorRadiusMm", kAxisMm);
  sequence.frames.resize(std::size_t{fan.frames} * grid.volumes);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const std::size_t volume = i / fan.frames;
    const std::size_t frame = i % fan.frames;
    double begun_s = kAssumedFrameS * static_cast<double>(volume * fan.frames);
    double step_s = kAssumedFrameS;
    if (!grid.volume_times_s.empty()) {
      const auto& times_s = grid.volume_times_s;
      begun_s = times_s[volume];
      const double lasts_s =
          volume + 1 < times_s.size() ? times_s[volume + 1] - begun_s : kAssumedFrameS * fan.frames;
      step_s = std::min(kAssumedFrameS, lasts_s / fan.frames);
    }
    SequenceFrame& of = sequence.frames[i];
    of.motor_angle_deg = degrees(fan.angle_rad(frame));
    of.timestamp_s = begun_s + step_s * static_cast<double>(frame);
    of.volume_index = volume;
    of.frame_index = static_cast<std::uint32_t>(frame);
  }
  sequence.notes.push_back(
      fmt::format("This is a volume on a grid of {} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm, read as "
                  "{} planes of a "
                  "fan whose axis lies {} mm above the probe's face.",
                  grid.size[0], grid.size[1], grid.size[2], grid.spacing_mm[0], grid.spacing_mm[1],
                  grid.spacing_mm[2], fan.frames, kAxisMm));
  if (!grid.origin_mm) {
    sequence.notes.emplace_back(
        "Its orientation to a probe is not known: its second axis is taken to lead into the body, and its "
        "first "
        "rows "
        "to lie at the face.");
  }
  if (grid.is_left_handed)
    sequence.notes.emplace_back("Its axes are left-handed: the first one is turned round.");
  if (grid.volume_times_s.size() < 2) {
    sequence.notes.push_back(fmt::format("It has no time: {} s for each plane is assumed.", kAssumedFrameS));
  }
  return sequence;
}

std::unique_ptr<FrameReader> fan_reader(const VoxelGrid& grid, PixelFormat format,
                                        std::vector<std::uint8_t> voxels) {
  const bool swapped = format.big_endian != (std::endian::native == std::endian::big);
  if (format.bytes == 1) {
    if (format.is_signed) return std::make_unique<FanReader<std::int8_t>>(grid, false, std::move(voxels));
    return std::make_unique<FanReader<std::uint8_t>>(grid, false, std::move(voxels));
  }
  if (format.is_signed) return std::make_unique<FanReader<std::int16_t>>(grid, swapped, std::move(voxels));
  return std::make_unique<FanReader<std::uint16_t>>(grid, swapped, std::move(voxels));
}

}  // namespace fanlight
