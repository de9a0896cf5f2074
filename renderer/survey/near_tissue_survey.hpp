// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/model/echo_levels.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/near_tissue.hpp"

namespace fanlight {

/// Looks for near tissue with fluid behind it in a coarse copy of the volume. nullopt: there is none, or most
/// of what lies behind touches it, or the grey levels are not known. Deterministic. Reads up to
/// 40 whole frames; allocates.
std::optional<NearTissue> find_near_tissue(const Volume& volume, const EchoLevels& levels);

/// Looks for what the scene removes: what lies before a closed bright shell (find_shell); where there is
/// none, or that is shown, near tissue before fluid. Deterministic; allocates.
NearTissueSearch search_near_tissue(const Volume& volume, const EchoLevels& levels,
                                    const Scene::Near& wanted);

/// Near tissue that is steady over volumes: a slow mean, which follows at once where much has moved. What is
/// in force changes only where the mean has left it, so that a still scene is not cast again.
class SteadyNearTissue {
 public:
  /// Takes what a search found, and sets that to what is in force. `wanted`: by the scene that was searched
  /// for; `geometry`: of the volume. Another one of either discards the mean. What is in force is given up
  /// after three volumes in a row without it.
  void add(NearTissueSearch& search, const Scene::Near& wanted, const FanGeometry& geometry);

 private:
  void follow(const NearTissue& found);

  FanGeometry geometry_;
  Scene::Near wanted_;
  std::optional<NearTissue> mean_;
  std::optional<NearTissue> in_force_;
  bool ends_at_bone_ = false;  // of in_force_
  std::uint32_t without_ = 0;  // volumes in a row
};

}  // namespace fanlight
