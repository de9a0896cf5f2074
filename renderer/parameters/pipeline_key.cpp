// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/pipeline_key.hpp"

namespace fanlight {

std::string_view name_of(Shader shader) {
  switch (shader) {
    case Shader::kBox:
      return "box";
    case Shader::kMedian:
      return "median";
    case Shader::kGuidedFit:
      return "guided_fit";
    case Shader::kGuidedApply:
      return "guided_apply";
    case Shader::kBlockMinMax:
      return "block_min_max";
    case Shader::kNeighbourMinMax:
      return "neighbour_min_max";
    case Shader::kPack:
      return "pack";
    case Shader::kEmptySpace:
      return "empty_space";
    case Shader::kDirtyTiles:
      return "dirty_tiles";
    case Shader::kCast:
      return "cast";
    case Shader::kFrameSteps:
      return "frame_steps";
    case Shader::kSlice:
      return "slice";
    case Shader::kTemporal:
      return "temporal";
    case Shader::kTileDepthRange:
      return "tile_depth_range";
    case Shader::kCleanupTiles:
      return "cleanup_tiles";
    case Shader::kIslands:
      return "islands";
    case Shader::kConfidence:
      return "confidence";
    case Shader::kHoles:
      return "holes";
    case Shader::kMeanRows:
      return "mean_rows";
    case Shader::kMeanColumns:
      return "mean_columns";
    case Shader::kSmooth:
      return "smooth";
    case Shader::kMinDepth:
      return "min_depth";
    case Shader::kSoftLight:
      return "soft_light";
    case Shader::kScatter:
      return "scatter";
    case Shader::kLight:
      return "light";
    case Shader::kDiffuse:
      return "diffuse";
    case Shader::kFinish:
      return "finish";
  }
  return "";
}

}  // namespace fanlight
