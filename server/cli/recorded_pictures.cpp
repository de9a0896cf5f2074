// SPDX-License-Identifier: Apache-2.0
#include "server/cli/recorded_pictures.hpp"
#include "server/cli/json_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "acquisition/offline_volumes.hpp"
#include "acquisition/record/recording_names.hpp"
#include "renderer/render_once.hpp"
#include "renderer/schedule/rate_governor.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/cli/picture_file.hpp"
#include "server/cli/picture_series.hpp"
#include "server/state/picture_note.hpp"

namespace fanlight {

namespace {

std::vector<RecordedCorrection> corrections_of(const PictureNotes& notes) {
  std::map<std::uint64_t, double> by_first_frame;
  for (const NotedPicture& picture : notes.pictures)
    by_first_frame[picture.first_frame_sequence] = picture.angle_correction_rad;
  std::vector<RecordedCorrection> corrections;
  corrections.reserve(by_first_frame.size());
  for (const auto& [first, correction_rad] : by_first_frame) corrections.push_back({first, correction_rad});
  return corrections;
}

class RecordedPictures {
 public:
  RecordedPictures(const RecordedPicturesOptions& options, PictureNotes notes)
      : options_(options), notes_(std::move(notes)), corrections_(corrections_of(notes_)) {}

  Result<void> render_all() {
    Doorbell bell;
    ProbeLink probe(bell, bell);
    auto source = open_source(options_.input, options_.playing, probe);
    if (!source) return source.error();
    if (auto made = make_renderer((*source)->description()); !made) return made;
    OfflineVolumes volumes(**source, corrections_);
    for (;;) {
      const auto volume = volumes.next();
      if (!volume) return volume.error();
      if (!*volume) return {};
      for (const NotedPicture& picture : notes_.pictures) {
        const VolumeStamp& stamp = (*volume)->stamp();
        if (picture.first_frame_sequence != stamp.first_frame_sequence ||
            picture.last_frame_sequence != stamp.last_frame_sequence)
          continue;
        if (auto rendered = render(picture, **volume); !rendered) return rendered;
      }
    }
  }

  Result<void> report() const {
    const std::size_t left_out = notes_.pictures.size() - rendered_;
    if (options_.json) {
      fmt::print("{}\n", json_text(nlohmann::ordered_json({{"input", options_.input},
                                                           {"pictures", rendered_},
                                                           {"left_out", left_out},
                                                           {"scene_unknown", scene_unknown_},
                                                           {"steady", steady_}})));
    } else {
      fmt::print("{} pictures of {}\n", rendered_, options_.input);
      if (left_out > 0) {
        fmt::print(
            "{} more were shown meanwhile: {} of a scene that was not noted, the others of volumes whose "
            "frames "
            "are not all in the recording, or of half a sweep\n",
            left_out, scene_unknown_);
      }
      if (steady_ > 0) {
        fmt::print(
            "{} of them with filter.steady above 0, refresh frame or near tissue removed: they may "
            "differ from what was shown\n",
            steady_);
      }
    }
    if (rendered_ > 0) return {};
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: none of the pictures can be rendered again, expected a volume with all its "
                             "frames in the recording",
                             options_.input)};
  }

 private:
  Result<void> make_renderer(const SourceDescription& source) {
    auto device = open_device(options_.gpu);
    if (!device) return device.error();
    device_ = std::move(*device);
    usual_size_ = notes_.pictures.front().usual;
    PictureSize largest = usual_size_;
    for (const NotedPicture& picture : notes_.pictures) {
      if (picture.usual == usual_size_ && picture.size.pixels() > largest.pixels()) largest = picture.size;
    }
    auto renderer =
        Renderer::create({.size = usual_size_,
                          .largest_size = largest,
                          .geometry = source.geometry,
                          .first_angle_rad = source.first_angle_rad,
                          .last_angle_rad = source.last_angle_rad,
                          .frame_capacity = source.frames_per_volume,
                          .usual_frames = source.usual_frames},
                         {.gpu = *device_.gpu, .counters = counters_}, {.revision = 1, .scene = {}});
    if (!renderer) return renderer.error();
    renderer_ = std::move(*renderer);
    return {};
  }

  Result<void> render(const NotedPicture& picture, const Volume& volume) {
    const auto scene = notes_.scenes.find(picture.scene_revision);
    if (scene == notes_.scenes.end()) ++scene_unknown_;
    // A server has one usual size; pictures of another belong to an earlier recording.
    if (scene == notes_.scenes.end() || picture.usual != usual_size_) return {};
    renderer_->fix_levels(picture.levels);
    Scene wanted = degraded(scene->second, picture.measures, volume.geometry().finest_mm());
    if (picture.size != usual_size_) wanted.size = picture.size;
    renderer_->show({.revision = ++shown_, .scene = wanted});
    if (auto settled = finish_shown(); !settled) return settled;
    const auto made = render_once(*renderer_, volume);
    if (!made) return made.error();
    const bool removes = scene->second.near.is_removed();
    const bool blends = scene->second.refresh == Refresh::kFrame && scene->second.filter.seam_frames > 0;
    if (scene->second.filter.steady > 0 || removes || blends) ++steady_;
    ++rendered_;
    return write_picture(numbered_file(options_.out, picture.picture_id, 6), *made, {});
  }

  /// The volume before is shown once more, in the new scene; that picture is of no use.
  Result<void> finish_shown() {
    constexpr std::int64_t kSecondNs = 1'000'000'000;
    for (;;) {
      if (auto advanced = renderer_->advance(); !advanced) return advanced;
      if (renderer_->collect(unused_)) continue;
      if (!renderer_->busy()) return {};
      if (auto waited = renderer_->wait(kSecondNs); !waited) return waited;
    }
  }

  const RecordedPicturesOptions& options_;
  PictureNotes notes_;
  std::vector<RecordedCorrection> corrections_;
  RenderDevice device_;
  RenderCounters counters_;
  PictureSize usual_size_;
  std::unique_ptr<Renderer> renderer_;
  Picture unused_;
  std::uint64_t shown_ = 1;
  std::size_t rendered_ = 0;
  std::size_t scene_unknown_ = 0;
  std::size_t steady_ = 0;
};

}  // namespace

Result<void> render_recorded_pictures(const RecordedPicturesOptions& options) {
  auto notes = read_picture_notes(picture_notes_path_of(options.input));
  if (!notes) return notes.error();
  if (notes->pictures.empty()) {
    return Error{
        ErrorCode::kNotFound,
        fmt::format("{}: no picture was shown while it was recorded, expected one at least", options.input)};
  }
  RecordedPictures pictures(options, *std::move(notes));
  if (auto rendered = pictures.render_all(); !rendered) return rendered;
  return pictures.report();
}

}  // namespace fanlight
