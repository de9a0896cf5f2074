// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

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

  /// `wanted`: false: never looks. Both must outlive this object.
  DefaultView(bool wanted, SceneStore& scene_store, SurveyDesk& surveys);

  /// A picture was shown.
  void picture_shown(std::int64_t now_ns);

  /// The answer to this object's own look (SurveyDesk::kServer). True: the scene, or the default, differs
  /// now.
  bool answered(const v1::SurveyReply& reply);

  /// SceneStore::suggest() for another geometry of the source; looks again where nobody has changed the
  /// scene.
  bool source_changed(const Scene& suggested);

  /// What was found, to be shown beside the picture; empty: it has not looked.
  const std::string& note() const { return note_; }

 private:
  bool untouched() const { return scene_store_.in_force().revision == own_revision_; }
  bool suggest(const Scene& scene);

  const bool wanted_;
  SceneStore& scene_store_;
  SurveyDesk& surveys_;
  Scene for_source_;  // suggested for the geometry alone
  std::uint64_t own_revision_ = 0;
  bool found_ = false;
  std::int64_t next_ns_ = 0;
  std::string note_;
};

}  // namespace fanlight
