// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "acquisition/igtl/frame_notes.hpp"
#include "acquisition/sequence/fan_fit.hpp"
#include "acquisition/sequence/image_orientation.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/igtl/image_body.hpp"
#include "proto/igtl/metadata.hpp"

namespace fanlight {

/// An image as it came, with what was said of it.
struct IgtlImage {
  igtl::ImageBody body;
  std::span<const std::uint8_t> pixels;  ///< as stored; of the whole image
  igtl::Metadata metadata;
  FrameNotes notes;
  std::int64_t time_ns = 0;  ///< the sender's, ns since 1970; without one, of its arrival
};

/// How a sender stores its pixels; nullopt: not as 8 or 16 bit whole numbers.
std::optional<PixelFormat> pixel_format(const igtl::ImageBody& image);

/// Why an image is none that a sweep is made of; empty: it is.
std::string why_no_frame(const igtl::ImageBody& image);

/// Columns and rows of the frames that these images become.
FrameSize frame_size(const igtl::ImageBody& image, const ImageOrientation& orientation);

/// The pose of a frame; nullopt where its columns are the rows of the image.
std::optional<ImagePose> frame_pose(const igtl::GridPose& grid, const ImageOrientation& orientation,
                                    FrameSize size);

}  // namespace fanlight
