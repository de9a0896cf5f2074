// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "acquisition/open_source.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

struct RecordedPicturesOptions {
  std::string input;      ///< a recording of `fanlight serve`
  SourceOptions playing;  ///< as fast as taken
  std::string out;        ///< x.png: the pictures are x.000017.png, by their numbers in the stream
  std::string gpu;        ///< part of its name; empty: the best one
  bool json = false;
};

/// Renders the pictures that displays saw while a recording was made, by the notes next to it
/// (picture_note.hpp): on the same device the same pixels, except where filter.steady is above 0, near tissue
/// is removed, or refresh is frame: these also take the pictures before. Prints how many there are, and how
/// many cannot be rendered again, with the reason. Errors: kNotFound: there are no notes, or none of the
/// pictures can be rendered; those of the recording and the GPU.
Result<void> render_recorded_pictures(const RecordedPicturesOptions& options);

}  // namespace fanlight
