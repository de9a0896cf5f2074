// SPDX-License-Identifier: Apache-2.0
#include "server/cli/input_renderer.hpp"

#include <fmt/format.h>

#include "acquisition/source/suggested_scene.hpp"
#include "proto/base/printable.hpp"
#include "renderer/render_once.hpp"
#include "server/cli/picture_file.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kMostSimulated = 9999;

Result<void> check_source(const RenderOptions& options, const SourceDescription& source) {
  if (source.simulated && options.volume.value_or(0) > kMostSimulated) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format(
            "--volume {} of the simulated probe, expected 0 to {}: all volumes before it must be simulated",
            *options.volume, kMostSimulated)};
  }
  if (options.all && !options.count && source.volumes == 0) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} has no end, expected --count with --all", options.input)};
  }
  return {};
}

}  // namespace

Result<void> check_render(const RenderOptions& options) {
  const auto size = parse_picture_size(options.size);
  if (!size) return size.error();
  if (auto named = check_files(options.files, *size); !named) return named;
  if (options.files.is_page() && !options.exports)
    return Error{ErrorCode::kInvalidArgument, "a page is no picture, expected fanlight export for it"};
  if (options.files.is_video() && !options.all)
    return Error{ErrorCode::kInvalidArgument, "a video shows many volumes, expected --all with it"};
  if (options.files.picture == kStandardOutput && options.all)
    return Error{ErrorCode::kInvalidArgument, "--all writes many pictures, expected a name and not -"};
  return {};
}

Result<std::unique_ptr<InputRenderer>> InputRenderer::create(const RenderOptions& options,
                                                             RenderDevice& device, PipelineStore* store) {
  if (auto good = check_render(options); !good) return good.error();
  std::unique_ptr<InputRenderer> made(new InputRenderer(options, device));
  InputRenderer& self = *made;
  self.size_ = *parse_picture_size(options.size);
  auto source = open_source(options.input, options.playing, self.probe_);
  if (!source) return source.error();
  self.source_ = *std::move(source);
  const SourceDescription& description = self.source_->description();
  if (auto good = check_source(options, description); !good) return good.error();
  self.expected_ = options.count ? static_cast<std::uint64_t>(*options.count) : description.volumes;
  self.suggested_ = suggested_scene(description, self.size_.height);
  const auto scene = options.scene.applied_to(self.suggested_);
  if (!scene) return scene.error();
  self.scene_ = *scene;
  self.finds_view_ = finds_view(options.automatic, options.scene, description);
  for (const std::string& note : description.notes) self.notes_.push_back(printable(note));
  if (!device.gpu) {
    auto opened = open_device(options.gpu);
    if (!opened) return opened.error();
    device = *std::move(opened);
  }
  auto renderer = Renderer::create({.size = self.size_,
                                    .geometry = description.geometry,
                                    .first_angle_rad = description.first_angle_rad,
                                    .last_angle_rad = description.last_angle_rad,
                                    .frame_capacity = description.frames_per_volume,
                                    .usual_frames = description.usual_frames},
                                   {.gpu = *device.gpu, .counters = self.counters_, .store = store},
                                   {.revision = 1, .scene = self.scene_});
  if (!renderer) return renderer.error();
  self.renderer_ = *std::move(renderer);
  self.volumes_.emplace(*self.source_);
  return made;
}

Result<bool> InputRenderer::next() {
  if (options_.count && pictures_ == static_cast<std::uint64_t>(*options_.count)) return false;
  const auto volume = volumes_->next();
  if (!volume) return volume.error();
  if (!*volume) return false;
  (void)volumes_->dropped();  // before its queue is full
  if (auto rendered = render(**volume); !rendered) return rendered.error();
  return true;
}

Result<void> InputRenderer::pick() {
  const auto volume = volumes_->pick(options_.volume);
  if (!volume) return volume.error();
  return render(**volume);
}

/// Chooses the scene by this volume, where the user did not choose it.
Result<void> InputRenderer::look_at(const Volume& volume) {
  const auto view = auto_view(volume, suggested_, options_.scene, size_);
  if (!view) return view.error();
  scene_ = view->scene;
  renderer_->show({.revision = 2, .scene = scene_});
  for (const std::string& choice : view->choices) notes_.push_back("auto: " + choice);
  notes_.push_back("auto: to repeat this without --auto: " + view->options);
  return {};
}

Result<void> InputRenderer::render(const Volume& volume) {
  if (pictures_ == 0 && finds_view_) {
    if (auto chosen = look_at(volume); !chosen) return chosen;
  }
  auto picture = render_once(*renderer_, volume);
  if (!picture) return picture.error();
  picture_ = *std::move(picture);
  ++pictures_;
  if (volume.stamp().frames_missing > 0) ++interpolated_;
  std::vector<std::string> notes = notes_;
  for (std::size_t i = 0; i < kSweepWarnings; ++i) {
    if (!volume.stamp().warnings.has(static_cast<SweepWarning>(i))) continue;
    ++warned_[i];
    notes.emplace_back(kSweepWarningTexts[i].sentence);
  }
  const std::uint64_t number = volume.stamp().source_volume_index;
  const bool in_series = options_.all || options_.files.is_page();
  const RenderFiles files = options_.all ? series_.numbered(number) : options_.files;
  if (in_series) {
    if (auto added = series_.add(picture_, number, notes, scene_); !added) return added;
  } else if (auto written = write_picture(files.picture, picture_, notes, files.access()); !written) {
    return written;
  }
  if (!options_.files.is_one_file()) {
    written_.push_back(files.picture);
  } else if (pictures_ == 1) {
    written_.push_back(options_.files.picture);
  }
  return write_depth_and_surface_of(files);
}

Result<void> InputRenderer::write_depth_and_surface_of(const RenderFiles& files) {
  if (files.depth.empty() && files.surface.empty()) return {};
  const auto depths = renderer_->read_depth();
  if (!depths) return depths.error();
  if (auto written = write_depth_and_surface(files, picture_, *depths); !written) return written;
  for (const std::string* const path : {&files.depth, &files.surface})
    if (!path->empty()) written_.push_back(*path);
  return {};
}

Result<RenderReport> InputRenderer::report() const {
  const auto depths = renderer_->read_depth();
  if (!depths) return depths.error();
  RenderReport report = report_of(options_.input, picture_, depths->smooth_mm);
  report.notes = notes_;
  if (pictures_ == 1 && scene_.filter.steady > 0)
    report.notes.emplace_back("filter.steady: one volume alone has nothing to be averaged with; use --all");
  report.device = device_.name();
  report.speckle_filter_left_out = counters_.volumes_unfiltered.value() > 0;
  return report;
}

}  // namespace fanlight
