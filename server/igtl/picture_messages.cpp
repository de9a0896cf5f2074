// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/picture_messages.hpp"

#include <fmt/format.h>
#include <openigtlink/igtl_polydata.h>

#include <algorithm>
#include <string>

#include "proto/igtl/pose_bodies.hpp"
#include "server/codec/surface_mesh.hpp"

namespace fanlight {

namespace {

using Bytes = std::vector<std::uint8_t>;
using Vector = std::array<double, 3>;

Vector along(const Vector& from, const Vector& direction, double length_mm) {
  return {from[0] + length_mm * direction[0], from[1] + length_mm * direction[1],
          from[2] + length_mm * direction[2]};
}
Vector scaled(const Vector& vector, double factor) {
  return along({}, vector, factor);
}

/// The middle one of the depths; 0 without a surface.
double middle_depth_mm(const Picture& picture) {
  std::vector<float> depths;
  depths.reserve(picture.depth_mm.size());
  std::ranges::copy_if(picture.depth_mm, std::back_inserter(depths), [](float each) { return each >= 0; });
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::ranges::nth_element(depths, middle);
  return *middle;
}

/// The rays meet where a pixel has no size; 0 in a parallel projection, where they do not meet.
double eye_to_view_plane_mm(const PictureView& view) {
  return view.mm_per_pixel_per_mm > 0 ? view.mm_per_pixel / view.mm_per_pixel_per_mm : 0;
}

igtl::ImageBody image_of(const Picture& picture, std::uint8_t components, igtl::ScalarType scalar) {
  igtl::ImageBody image{.components = components, .scalar = scalar, .pose = plane_of(picture)};
  image.size = image.part_size = {static_cast<std::uint16_t>(picture.width),
                                  static_cast<std::uint16_t>(picture.height), 1};
  return image;
}

void put_picture(Bytes& bytes, const Picture& picture) {
  igtl::put_image_header(bytes, image_of(picture, 3, igtl::ScalarType::kUint8));
  const std::size_t pixels = std::size_t{picture.width} * picture.height;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + 3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    std::copy_n(picture.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i), 3,
                bytes.begin() + static_cast<std::ptrdiff_t>(begin + 3 * i));
}

void put_depth(Bytes& bytes, const Picture& picture) {
  bytes.reserve(igtl::kImageHeaderBytes + sizeof(float) * picture.depth_mm.size());
  igtl::put_image_header(bytes, image_of(picture, 1, igtl::ScalarType::kFloat32));
  for (const float depth_mm : picture.depth_mm) {
    const float value = depth_mm >= 0 ? depth_mm : -1;
    const auto* const raw = reinterpret_cast<const std::uint8_t*>(&value);
    bytes.insert(bytes.end(), raw, raw + sizeof(value));
  }
}

/// Points, triangles, normals and colours, packed by the library.
void put_surface(Bytes& bytes, const Picture& picture) {
  SurfaceMesh mesh = mesh_of(picture);
  std::vector<float> colours;
  colours.reserve(3 * mesh.colours.size());
  for (const auto& colour : mesh.colours)
    for (const std::uint8_t each : colour) colours.push_back(static_cast<float>(each));
  std::vector<std::uint32_t> polygons;
  polygons.reserve(4 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    polygons.push_back(3);
    polygons.insert(polygons.end(), triangle.begin(), triangle.end());
  }
  const auto points = static_cast<igtl_uint32>(mesh.points_mm.size());
  std::string normals_name = "Normals";
  std::string colours_name = "Colors";
  igtl_polydata_attribute attributes[] = {
      {IGTL_POLY_ATTR_TYPE_NORMAL, 3, points, normals_name.data(),
       points > 0 ? mesh.normals[0].data() : nullptr},
      {IGTL_POLY_ATTR_TYPE_SCALAR, 3, points, colours_name.data(), colours.data()}};
  igtl_polydata_info info{};
  info.header.npoints = points;
  info.header.npolygons = static_cast<igtl_uint32>(mesh.triangles.size());
  info.header.size_polygons = static_cast<igtl_uint32>(polygons.size() * sizeof(std::uint32_t));
  info.header.nattributes = std::size(attributes);
  info.points = points > 0 ? mesh.points_mm[0].data() : nullptr;
  info.polygons = polygons.data();
  info.attributes = attributes;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + igtl_polydata_get_size(&info, IGTL_TYPE_PREFIX_NONE));
  igtl_polydata_pack(&info, bytes.data() + begin, IGTL_TYPE_PREFIX_NONE);
}

void put_content(Bytes& bytes, IgtlStream stream, const Picture& picture) {
  switch (stream) {
    case IgtlStream::kPicture:
      return put_picture(bytes, picture);
    case IgtlStream::kDepth:
      return put_depth(bytes, picture);
    case IgtlStream::kSurface:
      return put_surface(bytes, picture);
    case IgtlStream::kCamera:
      return igtl::put_transform(bytes, camera_of(picture));
    case IgtlStream::kVideo:
    case IgtlStream::kVolume:
    case IgtlStream::kFrames:
      break;  // they are written elsewhere
  }
}

}  // namespace

igtl::GridPose plane_of(const Picture& picture) {
  const PictureView& view = picture.stamp.view;
  const double depth_mm = middle_depth_mm(picture);
  const double pixel_mm = view.mm_per_pixel + depth_mm * view.mm_per_pixel_per_mm;
  Vector first = along(view.origin_mm, view.forward, depth_mm);
  first = along(first, view.right, -view.middle_column * pixel_mm);
  first = along(first, view.down, -view.middle_row * pixel_mm);
  return {.i_mm = scaled(view.right, pixel_mm),
          .j_mm = scaled(view.down, pixel_mm),
          .k_mm = view.forward,
          .first_mm = first};
}

igtl::GridPose camera_of(const Picture& picture) {
  const PictureView& view = picture.stamp.view;
  return {.i_mm = view.right,
          .j_mm = view.down,
          .k_mm = view.forward,
          .first_mm = along(view.origin_mm, view.forward, -eye_to_view_plane_mm(view))};
}

PictureMetadata::PictureMetadata(const PictureStamp& stamp)
    : texts_{std::to_string(stamp.picture_id), std::to_string(stamp.volume.volume_id),
             std::to_string(stamp.scene_revision), fmt::format("{}", eye_to_view_plane_mm(stamp.view))},
      items_{{{"FanlightPicture", texts_[0]},
              {"FanlightVolume", texts_[1]},
              {"FanlightSceneRevision", texts_[2]},
              {"FanlightEyeToViewPlaneMm", texts_[3]}}} {}

IgtlPictureMessages picture_messages(const Picture& picture, const IgtlWanted& wanted, std::uint64_t utc_ns) {
  const PictureMetadata metadata(picture.stamp);
  const IgtlMessageFacts facts{.utc_ns = utc_ns,
                               .id = static_cast<std::uint32_t>(picture.stamp.picture_id),
                               .metadata = metadata.items()};
  IgtlPictureMessages messages;
  for (const auto stream :
       {IgtlStream::kPicture, IgtlStream::kDepth, IgtlStream::kSurface, IgtlStream::kCamera}) {
    if (!wanted.has(stream)) continue;
    Bytes content;
    put_content(content, stream, picture);
    messages.at(stream) = stream_messages(stream, facts, content, wanted);
  }
  return messages;
}

}  // namespace fanlight
