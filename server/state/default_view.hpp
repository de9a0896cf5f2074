// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/model/picture.hpp"
#include "server/state/scene_store.hpp"
#include "server/state/survey_desk.hpp"

namespace fanlight {

/// Finds a view of a source for which no option chose one: looks for the surface after the first picture, and
/// again every kBetweenNs until it has found one, as long as no client changes the scene. What it finds
/// becomes the default scene. Server thread only.
class DefaultView {
 public:
  static constexpr std::int64_t kBetweenNs = 5'000'000'000;

  /// `wanted`: false: never looks. `notes`: about the source; what was found is added to them. All must
  /// outlive this object.
  DefaultView(bool wanted, SceneStore& scene_store, SurveyDesk& surveys, std::vector<std::string>& notes);

  /// A picture was shown.
  void picture_shown(const PictureStamp& stamp, std::int64_t now_ns);

  /// The answer to this object's own look (SurveyDesk::kServer). True: the scene, the default, or the notes
  /// differ now.
  bool answered(const SurveyDesk::Answer& answer);

  /// SceneStore::suggest() where `suggested`, the scene for the geometry of the source alone, differs from
  /// the last one. Looks again, at volumes that were captured after this call, where no one has changed the
  /// scene. True: as of answered().
  bool source_changed(const Scene& suggested, std::int64_t now_ns);

 private:
  bool untouched() const { return scene_store_.in_force().revision == own_revision_; }
  bool suggest(const Scene& scene, const std::string& sentence);
  /// Adds it to the notes, in place of an older one, and logs it. True: it is another.
  bool note(const std::string& sentence);

  const bool wanted_;
  SceneStore& scene_store_;
  SurveyDesk& surveys_;
  Scene for_source_;  // suggested for the geometry alone
  std::uint64_t own_revision_ = 0;
  bool looking_ = false;
  bool outdated_ = false;  // the answer that is awaited: it is of a volume of the geometry before
  bool found_ = false;
  bool is_unsure_ = false;  // what is shown was found, but is small or torn
  std::int64_t next_ns_ = 0;
  std::int64_t captured_from_ns_ = INT64_MIN;  // volumes captured earlier have another geometry
  std::vector<std::string>& notes_;
  const std::size_t source_notes_;  // the first ones, by count
};

}  // namespace fanlight
