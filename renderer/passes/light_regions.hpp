// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/pixel_rect.hpp"
#include "shaders/light_parameters.h"

namespace fanlight {

/// What each dispatch of passes 2 and 3 computes where pass 1 has changed a part of the picture only.
/// All else is as the last picture left it. In whole tiles, so that no dispatch writes beyond its rectangle.
struct LightRegions {
  PixelRect changed;   ///< the temporal filter, and the tiles' ranges of depth
  PixelRect uneven;    ///< where tiles may have got islands, holes or outlines
  PixelRect cleaned;   ///< islands
  PixelRect filled;    ///< holes
  PixelRect rows;      ///< the depth filter along rows
  PixelRect smooth;    ///< the depth filter along columns
  PixelRect lit;       ///< the light
  PixelRect outlined;  ///< pass 3, outlines
  PixelRect finished;  ///< pass 3, all else

  /// For a picture that is computed from the start.
  static LightRegions whole(PictureSize size);

  /// Where `changed` has other values than in the last picture, which had the same parameters. Each rectangle
  /// is as large as the windows of its pass, and takes in what a later pass has overwritten: the maps of two
  /// pairs of passes lie in the same memory (LightMemory::write_to()).
  ///
  /// `diffuses`: pass 3 takes steps that change both maps of the lit picture.
  static LightRegions of(const PixelRect& changed, const shaders::LightParameters& parameters, bool diffuses,
                         PictureSize size);
};

}  // namespace fanlight
