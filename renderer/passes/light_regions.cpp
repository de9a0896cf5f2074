// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/light_regions.hpp"

#include <algorithm>

namespace fanlight {

LightRegions LightRegions::whole(PictureSize size) {
  const PixelRect all = PixelRect::whole(size).grown(0, 0, size);
  return {all, all, all, all, all, all, all, all, all};
}

LightRegions LightRegions::of(const PixelRect& changed, const shaders::LightParameters& parameters,
                              bool diffuses, PictureSize size) {
  const auto grown = [size](const PixelRect& from, int across, int down) {
    return from.grown(across, down, size);
  };
  const int islands = parameters.islands_radius;
  const int holes = parameters.holes_radius;
  const int filter = parameters.filter_radius;
  const int cleanup_tiles = std::max((std::max(islands, holes) + kTileSide - 1) / kTileSide, 1);
  LightRegions regions = whole(size);
  const PixelRect all = regions.changed;
  regions.changed = grown(changed, 0, 0);
  regions.uneven = grown(regions.changed, kTileSide * cleanup_tiles, kTileSide * cleanup_tiles);
  regions.filled = grown(changed, islands + holes, islands + holes);
  // The holes' windows read the map without islands, whose memory the filtered depth map has overwritten.
  regions.cleaned = grown(regions.filled, holes, holes);
  regions.smooth = grown(regions.filled, filter, filter).united(regions.cleaned);
  // The lit picture lies in the memory of the filter's first half.
  regions.rows = grown(regions.smooth, 0, filter);
  // A shadow may fall anywhere, and soft light is computed for the whole picture; next to the surface, pixels
  // may show others' colours.
  const bool soft = parameters.occlusion > 0 || parameters.scatter_radius > 0 || parameters.fade_reach > 0;
  const bool far = soft || parameters.shadow < 1 || parameters.colours_from_left > 0 || diffuses;
  regions.lit = far ? all : regions.rows.united(grown(regions.smooth, 1, 1));
  regions.outlined = far ? all : grown(regions.lit, parameters.outline_radius, parameters.outline_radius);
  regions.finished = far ? all : grown(regions.outlined, 1, 1);
  return regions;
}

}  // namespace fanlight
