// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/dicom_planes.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcdatset.h>
#include <dcmtk/dcmdata/dcdeftag.h>
#include <dcmtk/dcmdata/dcitem.h>
#include <dcmtk/dcmdata/dcsequen.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "acquisition/replay/dicom_fields.hpp"

namespace fanlight {

using dicom::bad;

namespace {

/// Finds what a frame says: in its own item of the functional groups, else in the one that all share.
class Groups {
 public:
  explicit Groups(DcmItem& dataset) {
    DcmSequenceOfItems* sequence = nullptr;
    if (dataset.findAndGetSequence(DCM_SharedFunctionalGroupsSequence, sequence).good() &&
        sequence != nullptr && sequence->card() > 0)
      shared_ = sequence->getItem(0);
    if (dataset.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, sequence).good())
      per_frame_ = sequence;
  }

  void at(std::uint32_t frame) {
    // The list is walked along: getItem() counts from its beginning on.
    own_ = nullptr;
    if (per_frame_ != nullptr && frame < per_frame_->card()) {
      previous_ = static_cast<DcmItem*>(per_frame_->nextInContainer(frame == 0 ? nullptr : previous_));
      own_ = previous_;
    }
  }

  /// Item 0 of a group of the frame; nullptr: it has none.
  DcmItem* group(const DcmTagKey& key) const {
    for (DcmItem* const item : {own_, shared_}) {
      DcmItem* found = nullptr;
      if (item != nullptr && item->findAndGetSequenceItem(key, found, 0).good() && found != nullptr)
        return found;
    }
    return nullptr;
  }

  template <std::size_t kCount>
  std::optional<std::array<double, kCount>> numbers(const DcmTagKey& group_key, const DcmTagKey& key) const {
    DcmItem* const item = group(group_key);
    if (item == nullptr) return std::nullopt;
    std::array<double, kCount> found{};
    for (std::size_t i = 0; i < kCount; ++i) {
      Float64 value = 0;
      if (item->findAndGetFloat64(key, value, i).bad() || !std::isfinite(value)) return std::nullopt;
      found[i] = value;
    }
    return found;
  }

  /// An unknown kind of data is taken for tissue.
  bool is_tissue() const {
    DcmItem* const item = group(DCM_ImageDataTypeSequence);
    OFString type;
    if (item == nullptr || item->findAndGetOFString(DCM_DataType, type).bad()) return true;
    return type.empty() || type == "TISSUE_INTENSITY";
  }

 private:
  DcmItem* shared_ = nullptr;
  DcmSequenceOfItems* per_frame_ = nullptr;
  DcmItem* previous_ = nullptr;
  DcmItem* own_ = nullptr;
};

std::array<double, 3> cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

std::array<double, 3> column_of(const ImagePose& pose, std::size_t column) {
  return {pose[column], pose[4 + column], pose[8 + column]};
}

/// The direction across the first plane, of length 1.
std::array<double, 3> normal_of(const ImagePose& pose) {
  auto normal = cross(column_of(pose, 0), column_of(pose, 1));
  const double length = std::sqrt(dot(normal, normal));
  for (double& each : normal) each /= length;
  return normal;
}

std::optional<ImagePose> pose_of(const Groups& groups) {
  const auto position = groups.numbers<3>(DCM_PlanePositionVolumeSequence, DCM_ImagePositionVolume);
  const auto orientation = groups.numbers<6>(DCM_PlaneOrientationVolumeSequence, DCM_ImageOrientationVolume);
  const auto spacing = groups.numbers<2>(DCM_PixelMeasuresSequence, DCM_PixelSpacing);
  if (!position || !orientation || !spacing) return std::nullopt;
  const auto [row_mm, column_mm] = *spacing;
  const std::array<double, 3> x = {(*orientation)[0], (*orientation)[1], (*orientation)[2]};
  const std::array<double, 3> y = {(*orientation)[3], (*orientation)[4], (*orientation)[5]};
  const auto z = cross(x, y);
  // Unit vectors at right angles, up to how they are rounded.
  constexpr double kOff = 0.01;
  const bool upright =
      std::abs(dot(x, x) - 1) < kOff && std::abs(dot(y, y) - 1) < kOff && std::abs(dot(x, y)) < kOff;
  if (!upright || !(row_mm > 0 && column_mm > 0)) return std::nullopt;
  ImagePose pose{};
  for (std::size_t i = 0; i < 3; ++i) {
    pose[4 * i] = x[i] * column_mm;
    pose[4 * i + 1] = y[i] * row_mm;
    pose[4 * i + 2] = z[i];
    pose[4 * i + 3] = (*position)[i];
  }
  pose[15] = 1;
  return pose;
}

/// Counts the volumes by their times, and orders the planes of each by their place along the normal; planes
/// that turn stay in the file's order.
void put_in_order(std::vector<DicomPlane>& planes) {
  std::map<double, std::uint32_t> volumes;
  for (const DicomPlane& plane : planes) volumes.emplace(plane.time_s.value_or(0), 0);
  std::uint32_t count = 0;
  for (auto& volume : volumes) volume.second = count++;
  for (DicomPlane& plane : planes) plane.volume = volumes.at(plane.time_s.value_or(0));
  const auto normal = normal_of(planes.front().pose);
  const auto place = [&normal](const DicomPlane& plane) { return dot(normal, column_of(plane.pose, 3)); };
  const bool parallel = std::ranges::all_of(
      planes, [&](const DicomPlane& plane) { return std::abs(dot(normal, normal_of(plane.pose))) > 0.9999; });
  std::ranges::stable_sort(planes, [&](const DicomPlane& a, const DicomPlane& b) {
    if (a.volume != b.volume) return a.volume < b.volume;
    return parallel && place(a) < place(b);
  });
}

/// Where pixel (0, 0) of the first plane lies, if the rows of the grid lead along the transducer's x axis and
/// its columns away from the face.
std::optional<std::array<double, 3>> origin_in_transducer(const ImagePose& first,
                                                          const ImagePose& transducer) {
  constexpr double kLeastCosine = 0.9999;
  std::array<double, 3> origin{};
  std::array<double, 2> cosine{};
  for (std::size_t row = 0; row < 3; ++row) {
    origin[row] = transducer[4 * row + 3];
    for (std::size_t k = 0; k < 3; ++k) origin[row] += transducer[4 * row + k] * first[4 * k + 3];
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto vector = column_of(first, axis);
    for (std::size_t k = 0; k < 3; ++k) cosine[axis] += transducer[4 * axis + k] * vector[k];
    cosine[axis] /= std::sqrt(dot(vector, vector));
  }
  if (cosine[0] < kLeastCosine || cosine[1] < kLeastCosine) return std::nullopt;
  return origin;
}

}  // namespace

std::optional<ImagePose> volume_to_transducer(DcmItem& dataset) {
  ImagePose matrix{};
  for (std::size_t i = 0; i < matrix.size(); ++i) {
    Float64 value = 0;
    if (dataset.findAndGetFloat64(DCM_VolumeToTransducerMappingMatrix, value, i).bad() ||
        !std::isfinite(value))
      return std::nullopt;
    matrix[i] = value;
  }
  return matrix;
}

Result<std::vector<DicomPlane>> dicom_planes(DcmItem& dataset, std::uint32_t frames,
                                             const std::string& name) {
  Groups groups(dataset);
  std::vector<DicomPlane> planes;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    groups.at(frame);
    if (!groups.is_tissue()) continue;
    const auto pose = pose_of(groups);
    if (!pose) {
      return bad(
          name, fmt::format("frame {} of the volume has no place in it", frame),
          "Image Position (Volume), Image Orientation (Volume) of unit vectors at right angles, and Pixel "
          "Spacing of each frame");
    }
    const auto time_s = groups.numbers<1>(DCM_TemporalPositionSequence, DCM_TemporalPositionTimeOffset);
    planes.push_back(
        {.frame = frame, .time_s = time_s ? std::optional((*time_s)[0]) : std::nullopt, .pose = *pose});
  }
  if (planes.size() < 2)
    return bad(name, fmt::format("the volume has {} planes of tissue", planes.size()), "2 at least");
  const bool all_have_times =
      std::ranges::all_of(planes, [](const DicomPlane& plane) { return plane.time_s.has_value(); });
  if (!all_have_times) {
    for (DicomPlane& plane : planes) plane.time_s.reset();
  }
  put_in_order(planes);
  return planes;
}

Result<std::optional<VoxelGrid>> grid_of(const std::vector<DicomPlane>& planes, std::uint32_t columns,
                                         std::uint32_t rows, const ImagePose& transducer,
                                         const std::string& name) {
  const ImagePose& first = planes.front().pose;
  const auto normal = normal_of(first);
  constexpr double kLeastCosine = 0.9999;  // 0.8 deg
  for (const DicomPlane& plane : planes) {
    if (std::abs(dot(normal, normal_of(plane.pose))) < kLeastCosine) return std::optional<VoxelGrid>();
  }
  const std::uint32_t volumes = planes.back().volume + 1;
  const std::size_t in_each = planes.size() / volumes;
  const auto not_a_grid = [&](const std::string& why) {
    return bad(name, "its planes are parallel but form no grid: " + why,
               "planes at one distance, each above the other, as many in each volume",
               ErrorCode::kUnsupported);
  };
  if (in_each * volumes != planes.size() || in_each < 2)
    return not_a_grid(fmt::format("{} planes in {} volumes", planes.size(), volumes));
  const auto place = [&](std::size_t plane) { return dot(normal, column_of(planes[plane].pose, 3)); };
  const double step_mm = (place(in_each - 1) - place(0)) / static_cast<double>(in_each - 1);
  const std::array<double, 3> origin = column_of(first, 3);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const ImagePose& pose = planes[i].pose;
    const std::size_t in_volume = i % in_each;
    if (planes[i].volume != i / in_each) return not_a_grid("the volumes have different numbers of planes");
    // From where the plane would be in a grid, and how far its pixels turn or grow.
    double off_mm = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double there_mm = origin[k] + normal[k] * step_mm * static_cast<double>(in_volume);
      off_mm = std::max({off_mm, std::abs(pose[4 * k + 3] - there_mm),
                         std::abs(pose[4 * k] - first[4 * k]) * columns,
                         std::abs(pose[4 * k + 1] - first[4 * k + 1]) * rows});
    }
    const double most_mm = std::max(0.05 * step_mm, 0.001);
    if (off_mm > most_mm)
      return not_a_grid(fmt::format("plane {} is {:.3g} mm away from its place", i, off_mm));
  }
  const auto length = [&first](std::size_t column) {
    const auto vector = column_of(first, column);
    return std::sqrt(dot(vector, vector));
  };
  VoxelGrid grid{.size = {columns, rows, static_cast<std::uint32_t>(in_each)},
                 .spacing_mm = {length(0), length(1), step_mm},
                 .volumes = volumes};
  grid.origin_mm = origin_in_transducer(first, transducer);
  for (std::size_t i = 0; i < planes.size() && planes[i].time_s; i += in_each)
    grid.volume_times_s.push_back(*planes[i].time_s);
  if (grid.volume_times_s.size() != volumes) grid.volume_times_s.clear();
  return std::optional(grid);
}

}  // namespace fanlight
