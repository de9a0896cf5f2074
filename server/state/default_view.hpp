// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/fanlight.pb.h"
#include "server/state/scene_store.hpp"
#include "server/state/survey_desk.hpp"

namespace fanlight {

/// Finds a view of a source for which nobody has chosen one: has the render thread look for the surface after
/// the first picture, and again every kBetweenNs until it has found one, as long as nobody changes the scene.
/// What it finds becomes the default scene. Server thread only.
class DefaultView {
 public:
  static constexpr std::int64_t kBetweenNs = 5'000'000'000;

  /// `wanted`: false: never looks. `notes`: about the source; what was found is added to them. All must
  /// outlive this object.
  DefaultView(bool wanted, SceneStore& scene_store, SurveyDesk& surveys, std::vector<std::string>& notes);

  /// A picture was shown.
  void picture_shown(std::int64_t now_ns);

  /// The answer to this object's own look (SurveyDesk::kServer). True: the scene, or the default, differs
  /// now.
  bool answered(const v1::SurveyReply& reply);

  /// SceneStore::suggest() for another geometry of the source; looks again where nobody has changed the
  /// scene.
  bool source_changed(const Scene& suggested);

 private:
  bool untouched() const { return scene_store_.in_force().revision == own_revision_; }
  bool suggest(const Scene& scene);
  /// Adds it to the notes, in place of an older one, and logs it.
  void note(const std::string& sentence);

  const bool wanted_;
  SceneStore& scene_store_;
  SurveyDesk& surveys_;
  Scene for_source_;  // suggested for the geometry alone
  std::uint64_t own_revision_ = 0;
  bool found_ = false;
  std::int64_t next_ns_ = 0;
  std::vector<std::string>& notes_;
  const std::size_t source_notes_;  // the first so many
};

}  // namespace fanlight
