// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/replay/header_lines.hpp"
#include "acquisition/replay/sequence_header.hpp"

namespace fanlight {

/// The fields that MetaImage and NRRD sequences share: Seq_Frame0000_Name of a frame, and Fanlight's own.
/// Fills the header that it was given. One thread.
class FrameFields {
 public:
  static constexpr std::uint32_t kMostSide = 4096;
  static constexpr std::uint32_t kMostFrames = 1'000'000;

  /// Both must outlive this object.
  FrameFields(const NamedFile& from, SequenceHeader& header) : from_(from), header_(header) {}

  /// Takes a field whose name begins with Seq_Frame or Fanlight. Others: false.
  Result<bool> take(const HeaderField& field);

  /// Sets the size of the frames and their number. kBadInput: out of range, or fewer than the fields
  /// describe.
  Result<void> set_size(const HeaderField& field, std::uint64_t columns, std::uint64_t rows,
                        std::uint64_t frames);
  /// Sets the orientation by its letters.
  Result<void> set_orientation(const HeaderField& field);

  /// After the last field: whether there is a size, an orientation, and a field of a frame.
  Result<void> check() const;

  /// Whether a field of a frame, or an orientation of frames, was taken.
  bool describe_frames() const { return last_frame_ || has_orientation_; }

 private:
  /// A field of one frame: Seq_Frame0000_Name.
  struct OfFrame {
    SequenceFrame& frame;
    std::uint32_t index;
    std::string_view name;
  };
  Result<OfFrame> of_frame(const HeaderField& field);
  Result<void> take_frame_field(const HeaderField& field);
  Result<void> take_transform(const HeaderField& field, const OfFrame& of);
  template <typename T>
  Result<void> take_number(const HeaderField& field, std::optional<T>& number,
                           std::string_view expected) const;
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return from_.bad(wrong, expected, code);
  }

  const NamedFile& from_;
  SequenceHeader& header_;
  bool has_size_ = false;
  bool has_orientation_ = false;
  std::optional<std::uint32_t> last_frame_;
  std::map<std::string, std::string, std::less<>> keys_of_frame_;  // of the frame that was described last
};

}  // namespace fanlight
