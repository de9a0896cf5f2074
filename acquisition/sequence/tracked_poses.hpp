// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "acquisition/sequence/fan_fit.hpp"
#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/image_orientation.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// The pose of an image after its axes were turned: columns ascend to the marked side, rows go away from the
/// probe. `size`: after that. Of an image whose rows are columns (lines_in_rows) there is none.
ImagePose turned(ImagePose pose, const ImageOrientation& orientation, FrameSize size);

/// The motor angles of a sweep whose frames have poses (ImageToReferenceTransform) and no angles, by the fan
/// that fits them best; written to the frames. Frames without a pose are then invalid. nullopt: there are no
/// poses, or the frames have angles. kUnsupported: the poses form no fan, and how far they are from one.
Result<std::optional<FanFit>> fit_poses(const std::filesystem::path& path, FrameSequence& sequence,
                                        const ImageOrientation& orientation);

/// kUnsupported for a sweep of a tracked probe without motor angles, whose poses are not those of its images:
/// its frames lie wherever the hand was.
Result<void> refuse_tracked_by_hand(const std::filesystem::path& path, const FrameSequence& sequence);

}  // namespace fanlight
