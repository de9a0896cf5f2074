// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/base/result.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// Decides which scene is in force. Usually it is the wanted scene. If the driver fails to build its
/// pipelines, it is the last scene that was drawn, and the wanted one is tried again later. Pure logic: time
/// is a parameter. Render thread only.
class SceneFallback {
 public:
  explicit SceneFallback(const NumberedScene& first) : wanted_(first), in_force_(first), proven_(first) {}

  /// Sets the scene of all following pictures.
  void want(const NumberedScene& scene) {
    wanted_ = in_force_ = scene;
    rest_ns_ = kLeastRestNs;
  }
  const NumberedScene& wanted() const { return wanted_; }
  const NumberedScene& in_force() const { return in_force_; }
  /// The last scene that a picture was made of.
  const NumberedScene& proven() const { return proven_; }

  /// The scene in force could not be drawn. True where the proven scene is in force now; false where the
  /// error is a loss, or the proven scene itself cannot be drawn.
  bool falls_back(const Error& error, std::int64_t now_ns);
  /// The view of the scene in force is being cast: it is not refused any more.
  void note_begun() {
    if (in_force_.revision == wanted_.revision) refusal_.clear();
  }
  /// A picture is made of the scene in force.
  void note_drawn();

  /// Why a wanted scene was not drawn: the driver's error. Empty where it was, or was not tried yet.
  const std::string& refusal() const { return refusal_; }
  /// The revision of that scene.
  std::uint64_t refused_revision() const { return refused_revision_; }
  /// When try_again() brings a refused scene back; absent where none is refused.
  std::optional<std::int64_t> next_try_ns() const;
  /// Brings a refused scene into force again where that is due. To be called before the scene is used.
  void try_again(std::int64_t now_ns);

 private:
  // A refused scene is tried again after this time, and then after twice the time before, since each try
  // costs a cast and may cost a compilation.
  static constexpr std::int64_t kLeastRestNs = 1'000'000'000;
  static constexpr std::int64_t kMostRestNs = 64'000'000'000;

  NumberedScene wanted_;
  NumberedScene in_force_;
  NumberedScene proven_;
  std::string refusal_;
  std::uint64_t refused_revision_ = 0;
  std::int64_t refused_ns_ = 0;
  std::int64_t rest_ns_ = kLeastRestNs;  // until the next try
};

}  // namespace fanlight
