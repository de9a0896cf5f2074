// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "proto/igtl/image_body.hpp"
#include "proto/model/picture.hpp"
#include "server/igtl/stream_message.hpp"

namespace fanlight {

/// The messages of one picture, by stream.
struct IgtlPictureMessages {
  std::array<IgtlMessages, kIgtlStreams> of;

  IgtlMessages& at(IgtlStream stream) { return of[static_cast<std::size_t>(stream)]; }
};

/// The plane of a picture in space: at the middle depth of its surface, parallel to the view plane, so that a
/// 2D image lies where the surface is. In a perspective it has the size that the picture has there. Without a
/// surface: the view plane.
igtl::GridPose plane_of(const Picture& picture);

/// The metadata of what shows a picture; keeps their texts.
class PictureMetadata {
 public:
  explicit PictureMetadata(const PictureStamp& stamp);
  PictureMetadata(const PictureMetadata&) = delete;  // the items refer to the texts
  PictureMetadata& operator=(const PictureMetadata&) = delete;
  igtl::MetadataItems items() const { return items_; }

 private:
  std::array<std::string, 4> texts_;
  std::array<std::pair<std::string_view, std::string_view>, 4> items_;
};

/// Where the camera is: its axes to the right, down and forward, and its eye. In a parallel projection the
/// eye is in the view plane.
igtl::GridPose camera_of(const Picture& picture);

/// Writes the wanted messages of all streams that show nothing but this picture: not those of video, volume
/// and frames. `utc_ns`: when the frames of the picture's volume were taken, since 1970. Version 2 has
/// metadata: the picture's and the volume's ids, the scene's revision. Any thread. Allocates; bad_alloc
/// passes.
IgtlPictureMessages picture_messages(const Picture& picture, const IgtlWanted& wanted, std::uint64_t utc_ns);

}  // namespace fanlight
