// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "acquisition/sequence/recorded_frame.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/igtl/image_body.hpp"
#include "proto/igtl/message_writer.hpp"
#include "proto/model/frame_origin.hpp"

namespace fanlight {

/// Writes the frames of a source as IMAGE messages, from which IgtlSource gives the same frames again. With
/// version 2, metadata have all that a recording says of a frame and of its source, where the frames come
/// from, and how old each is: a relay of a recording, or of old frames, is not live. One thread.
class SentFrames {
 public:
  /// `facts`: of the source; the geometry is each frame's own.
  explicit SentFrames(const RecordingFacts& facts) : facts_(facts) {}

  /// Name of the device: pixels of the frame in the transducer frame.
  static constexpr const char* kDevice = "Image_Transducer";

  /// When a frame was taken, and where, at the time of its sending.
  struct Provenance {
    std::uint64_t utc_ns = 0;  ///< when it was taken, since 1970
    std::int64_t age_ns = 0;   ///< how long ago that was
    FrameOrigin origin = FrameOrigin::kProbe;
  };
  /// The message of a usable frame; valid until the next call.
  std::span<const std::uint8_t> message(const QueuedFrame& frame, const Provenance& provenance,
                                        igtl::HeadVersion version);

 private:
  RecordingFacts facts_;
  igtl::MessageWriter writer_;
};

/// Where the pixels of a frame are in the transducer frame. Scan lines of a curved array lie on no grid: they
/// are placed as if they were parallel, a line and a sample 1 mm wide.
igtl::GridPose frame_place(const FanGeometry& geometry, double angle_rad);

}  // namespace fanlight
