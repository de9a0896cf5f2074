// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/sequence/recorded_frame.hpp"
#include "acquisition/source/frame_source.hpp"

namespace fanlight {

/// Names of the frame fields that are Fanlight's own, behind Seq_Frame0000_. With them, a replay gives the
/// assembler the same stamps as the source did. PLUS and 3D Slicer keep fields that they do not know.
namespace plus_field {
inline constexpr std::string_view kFrameSequence = "FrameSequence";  ///< FrameStamp::sequence
inline constexpr std::string_view kFramesInSweep = "FramesInSweep";  ///< absent: 0
inline constexpr std::string_view kMotorAngleRad = "MotorAngleRad";  ///< every bit; degrees are rounded
inline constexpr std::string_view kFrameFault = "FrameFault";        ///< absent: none
inline constexpr std::string_view kAfterInterruption = "AfterInterruption";  ///< "1"; absent: no
// Of frames that are sent on, not of recordings. Names that begin with Fanlight describe all frames alike.
inline constexpr std::string_view kOrigin = "FrameOrigin";  ///< a name of FrameOrigin
inline constexpr std::string_view kAgeMs = "FrameAgeMs";    ///< from the capture to the sending
}  // namespace plus_field

/// What a recording of this source says of all its frames, but for the time of its begin.
RecordingFacts facts_of(const SourceDescription& source);

/// "invalid", "damaged", "cut" or "misfit"; empty for kNone.
std::string_view fault_name(FrameFault fault);
/// nullopt for another name.
std::optional<FrameFault> fault_named(std::string_view name);

/// Names and values, in order.
using PlusFields = std::vector<std::pair<std::string, std::string>>;
/// What Fanlight writes about all frames of a source, in the header of a recording or elsewhere: fields named
/// Fanlight..., from which find_geometry() and recording_facts() read it again.
PlusFields fanlight_fields(const RecordingFacts& facts);
/// What is written about one frame, except its place in the file and in space.
PlusFields frame_fields(const RecordingFacts& facts, const RecordedFrame& frame);

/// Lines of the header that belong to no frame, in PLUS/IGSIO's order and words (field-conventions of the
/// format: IGSIO, vtkIGSIOMetaImageSequenceIO.cxx), and Fanlight's geometry and facts. The image orientation
/// is MF: columns to the marked side, rows away from the probe. CompressedDataSize, where there is one, is
/// padded: it can be overwritten in place.
struct PlusHeader {
  std::uint64_t frames = 0;
  std::optional<std::uint64_t> compressed_bytes;  ///< absent: not compressed
};
std::string plus_header(const RecordingFacts& facts, const PlusHeader& header);

/// Appends the lines of one frame. `first_time_ns`: capture time of the recording's first frame, which is 0
/// s. `last_time_s`: the time of the frame before; the times of a PLUS sequence never fall, also where a
/// frame comes out of order. Returns the time written. ImageToReferenceTransform leads from pixels to mm in
/// the transducer frame (FanGeometry); scan lines of a curved array have none.
double add_plus_frame(std::string& text, std::uint64_t index, const RecordingFacts& facts,
                      const RecordedFrame& frame, std::int64_t first_time_ns, double last_time_s);

/// "ElementDataFile = LOCAL" or the name of the file with the pixels; the last line of a header.
std::string plus_data_line(std::string_view file);

}  // namespace fanlight
