// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "proto/igtl/image_body.hpp"
#include "proto/igtl/message_writer.hpp"
#include "proto/model/picture.hpp"
#include "server/igtl/igtl_streams.hpp"

namespace fanlight {

/// A whole OpenIGTLink message, shared by all clients that are sent it.
using IgtlMessage = std::shared_ptr<const std::vector<std::uint8_t>>;

/// The messages of one picture, by stream and version of the header; null where nobody wanted them.
struct IgtlPictureMessages {
  std::array<std::array<IgtlMessage, 2>, kIgtlStreams> of;

  IgtlMessage& at(IgtlStream stream, igtl::HeadVersion version) {
    return of[static_cast<std::size_t>(stream)][version == igtl::HeadVersion::kOne ? 0 : 1];
  }
};

/// The streams that clients want in each version.
struct IgtlWanted {
  IgtlStreams version_1;
  IgtlStreams version_2;
};

/// The plane of a picture in space: at the middle depth of its surface, parallel to the view plane, so that a
/// 2D image lies where the surface is. In a perspective it has the size that the picture has there. Without a
/// surface: the view plane.
igtl::GridPose plane_of(const Picture& picture);

/// Where the camera is: its axes to the right, down and forward, and its eye. In a parallel projection the
/// eye is in the view plane.
igtl::GridPose camera_of(const Picture& picture);

/// Writes the wanted messages. `utc_ns`: when the frames of the picture's volume were taken, since 1970.
/// Version 2 has metadata: the picture's and the volume's ids, the scene's revision. Any thread. Allocates;
/// bad_alloc passes.
IgtlPictureMessages picture_messages(const Picture& picture, const IgtlWanted& wanted, std::uint64_t utc_ns);

}  // namespace fanlight
