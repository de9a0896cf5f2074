// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/light_pass.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"
#include "shaders/map_totals.h"

namespace fanlight {

namespace {

using Copies = LightPass::Config::Copies;

// Rows, columns or tiles that a group of pass 2's shaders handles.
constexpr std::uint32_t kLines = 8;

constexpr float kFarthestMm = FANLIGHT_MAX_DEPTH;

// Other work waits for one piece: of a view that pauses the main view, else a changed light.
constexpr double kPieceMs = 4;

// The GPU's part of a filter takes some milliseconds. One that hangs is found where the render thread waits.
constexpr std::uint64_t kReaderNs = 100'000'000;

/// A dispatch over lines, tiles or columns from `first` to `end` - 1, and those that share its first and last
/// groups.
LightStep on_lines(VkPipeline pipeline, int first, int end) {
  const auto first_group = static_cast<std::uint32_t>(first) / kLines;
  return {.pipeline = pipeline,
          .groups_across = groups(static_cast<std::uint32_t>(end), kLines) - first_group,
          .first_across = first_group};
}

void set_smooth_part(shaders::LightParameters& parameters, const PixelRect& part) {
  parameters.smooth_left = part.left;
  parameters.smooth_top = part.top;
  parameters.smooth_right = part.right;
  parameters.smooth_bottom = part.bottom;
}

/// Unique in the process, also over views that come and go and over a GPU that is opened again: displays keep
/// surfaces by it.
std::uint64_t next_surface_id() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

int diffusion_steps(const Scene& scene) {
  return scene.finish.smoothing == Smoothing::kDiffusion ? scene.finish.iterations : 0;
}

}  // namespace

Result<LightPass> LightPass::create(const PassDevice& device, const Config& config) {
  LightPass made(config);
  const bool by_host = config.copies == Copies::kByHost;
  const auto usual_place = config.workers != nullptr ? BufferPlace::kFromGpu : BufferPlace::kDevice;
  auto memory = LightMemory::create(*device.gpu, config.largest,
                                    by_host ? BufferPlace::kFromGpu : usual_place, usual_place);
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  if (config.copies != Copies::kNone) {
    auto copies = CastMaps::create(*device.gpu, config.largest, by_host ? BufferPlace::kToGpu : usual_place);
    if (!copies) return copies.error();
    made.copies_ = std::move(*copies);
  }
  auto recorder = PassRecorder::create(device, {.name = "light pass", .pauses = config.pauses});
  if (!recorder) return recorder.error();
  made.recorder_ = std::move(*recorder);
  made.memory_.write_to(made.recorder_.descriptors());
  return made;
}

/// Takes over what is known of the cast. Returns what of it has changed.
LightPass::Change LightPass::take(const CastPass& cast) {
  const Input input{.depth = cast.maps().depth.get(), .number = cast.number(), .weighted = cast.weighted()};
  const bool other_cast = input.depth != input_.depth || input.number != input_.number;
  const bool other_weights = input.weighted != input_.weighted;
  const bool misses_weights = filter_ && filter_->weights == FilterWeights::kConfidence;
  input_ = input;
  farthest_mm_ = cast.farthest_mm();
  is_new_cast_ |= other_cast;
  is_new_input_ |= other_cast || (other_weights && misses_weights);
  return other_cast ? Change::kCast : other_weights ? Change::kWeights : Change::kNone;
}

void LightPass::name_maps(const CastMaps& maps) {
  if (std::exchange(named_maps_, maps.depth.get()) != maps.depth.get())
    maps.write_to(recorder_.descriptors());
  named_colours_ = maps.colour.get();
  if (here_.on()) here_.read(maps);
}

void LightPass::read(const CastPass& cast) {
  maps_to_copy_ = nullptr;
  const TimelinePoint written = cast.maps_written();
  if (written != std::exchange(written_, written)) awaits_maps_ = here_.on() && !cast.maps_are_written();
  name_maps(cast.maps());
  take(cast);
}

void LightPass::copy(const CastPass& cast) {
  name_maps(copies_);
  if (take(cast) == Change::kNone) return;
  written_ = cast.maps_written();
  maps_to_copy_ = &cast.maps();
  awaits_maps_ = here_.on();
}

void LightPass::copy_by_host(const CastPass& cast) {
  name_maps(copies_);
  if (take(cast) == Change::kNone) return;
  changed_ = changed_.united(copies_.copy_by_host(cast.maps(), cast.size()));
}

void LightPass::follow(const GpuBuffer& steady) {
  followed_ = steady.get();
  recorder_.descriptors().write(FANLIGHT_BINDING_EARLIER_MAP, steady);
}

/// Learns from the last picture how long a step of each stage takes.
void LightPass::learn_step_times() {
  // Steps over a part of the picture say nothing of whole ones.
  if (!in_pieces() || steps_.count() == 0 || !steps_.submitted() || partly_) return;
  const auto ms = stage_ms();
  for (const Stage stage : {Stage::kFilter, Stage::kLight, Stage::kFinish}) {
    const auto index = static_cast<std::size_t>(stage);
    const auto steps = static_cast<double>(steps_.count_of(stage));
    if (ms[index] <= 0) continue;
    // With pauses between its pieces the filter of a main view takes longer than its steps do.
    double& step_ms = step_ms_[index];
    step_ms = config_.pauses || step_ms == 0 ? ms[index] / steps : std::min(step_ms, ms[index] / steps);
  }
}

bool LightPass::MapsKey::operator==(const MapsKey& other) const {
  // All members have four bytes, without padding between them.
  using Words = std::array<std::uint32_t, sizeof(shaders::LightParameters) / sizeof(std::uint32_t)>;
  return diffusion_steps == other.diffusion_steps && temporal == other.temporal &&
         std::bit_cast<Words>(parameters) == std::bit_cast<Words>(other.parameters);
}

LightStep LightPass::on_tiles(VkPipeline pipeline, const PixelRect& part) const {
  const auto first_across = static_cast<std::uint32_t>(part.left / kTileSide);
  const auto first_down = static_cast<std::uint32_t>(part.top / kTileSide);
  return {.pipeline = pipeline,
          .groups_across = groups(static_cast<std::uint32_t>(part.right), kTileSide) - first_across,
          .groups_down = groups(static_cast<std::uint32_t>(part.bottom), kTileSide) - first_down,
          .first_across = first_across,
          .first_down = first_down};
}

/// Decides what passes 2 and 3 compute, and sets the part of the moving average in `parameters`.
void LightPass::choose_regions(const Scene& scene, int temporal, shaders::LightParameters& parameters) {
  const PixelRect all = PixelRect::whole(size_);
  regions_ = LightRegions::whole(size_);
  maps_due_ = {.parameters = parameters, .diffusion_steps = diffusion_steps(scene), .temporal = temporal};
  const bool as_last = is_new_input_ && maps_ == maps_due_ && filter_ == scene.filter;
  const PixelRect changed = changed_by_blending(scene.filter.seam_frames).united(changed_);
  partly_ = config_.copies == Copies::kByHost && config_.skipping == Skipping::kOn && as_last &&
            temporal != FANLIGHT_TEMPORAL_STEADY && 2 * changed.pixels() < all.pixels();
  if (partly_) {
    // Where nothing has changed, any tile.
    const PixelRect part = changed.empty() ? PixelRect{.right = 1, .bottom = 1} : changed;
    regions_ = LightRegions::of(part, parameters, maps_due_.diffusion_steps > 0, size_);
  }
  set_smooth_part(parameters, regions_.smooth);
  maps_.reset();
}

/// What the last pictures have changed whose frames the last one still blended.
PixelRect LightPass::changed_by_blending(int seam_frames) const {
  PixelRect changed;
  if (maps_due_.temporal != FANLIGHT_TEMPORAL_SEAM) return changed;
  // A pixel between two frames is blended until both are whole.
  const auto most = static_cast<std::uint64_t>(seam_frames);
  for (const ChangedPart& each : changed_parts_) {
    if (each.new_frames > 0 && new_frames_ - each.new_frames <= most) changed = changed.united(each.part);
  }
  return changed;
}

/// Writes the parameters of the temporal filter. Returns what it does: FANLIGHT_TEMPORAL_...
int LightPass::take_earlier(const Scene& scene, const Earlier& earlier, const Seam* seam) const {
  const MapPlace now{.view = picture_view(scene, size_), .size = size_};
  const auto shows = [](const MapPlace& place) { return place.view.part.width > 0; };
  auto& parameters = memory_.steady_parameters.mapped_as<shaders::SteadyParameters>();
  const double target_mm = scene.camera.distance_mm;
  if (seam != nullptr && shows(seam->earlier.place) && shows(now)) {
    parameters = steady_parameters(now, seam->earlier, target_mm, 0);
    parameters.seam = seam_parameters(now, *seam, scene.filter.seam_frames, new_frames_);
    return FANLIGHT_TEMPORAL_SEAM;
  }
  if (scene.filter.steady <= 0 || !earlier || !shows(earlier->place) || !shows(now))
    return FANLIGHT_TEMPORAL_ALONE;
  parameters = steady_parameters(now, *earlier, target_mm, scene.filter.steady);
  return FANLIGHT_TEMPORAL_STEADY;
}

/// The steps of the temporal filter.
Result<void> LightPass::add_steady_steps() {
  if (here_.on() && maps_due_.temporal == FANLIGHT_TEMPORAL_ALONE) {
    here_.add_step(steps_, shading::Step::kTake, regions_.changed, size_);
    return {};
  }
  Pipelines& pipelines = recorder_.pipelines();
  const bool averages = maps_due_.temporal == FANLIGHT_TEMPORAL_STEADY;
  const auto now_cells = pipelines.get(map_cells_key(false));
  if (!now_cells) return now_cells.error();
  const auto earlier_cells = pipelines.get(map_cells_key(true));
  if (!earlier_cells) return earlier_cells.error();
  const auto temporal = pipelines.get(temporal_key(maps_due_.temporal));
  if (!temporal) return temporal.error();
  const PixelRect cells{.right = FANLIGHT_MAP_CELLS, .bottom = FANLIGHT_MAP_CELLS};
  if (averages) {
    steps_.add(on_tiles(*now_cells, cells));
    steps_.add(on_tiles(*earlier_cells, cells));
    steps_.add({.pipeline = pipelines.fixed(Shader::kMapMotion), .groups_across = 1});
    steps_.add(on_tiles(pipelines.fixed(Shader::kMapDifferences), cells));
    steps_.add({.pipeline = pipelines.fixed(Shader::kMapAgreement), .groups_across = 1});
  }
  steps_.add(on_tiles(*temporal, regions_.changed));
  return {};
}

Result<void> LightPass::add_filter_steps(const LightKeys& keys) {
  if (auto added = add_steady_steps(); !added) return added;
  steady_steps_ = steps_.count();
  if (here_.on()) {
    here_.add_filter_steps(steps_, keys, regions_, size_);
    return {};
  }
  Pipelines& pipelines = recorder_.pipelines();
  auto rows = pipelines.get(keys.filter_rows);
  if (!rows) return rows.error();
  auto columns = pipelines.get(keys.filter_columns);
  if (!columns) return columns.error();
  const LightRegions& parts = regions_;
  const int tiles_across = static_cast<int>(groups(size_.width, kTileSide));
  const auto on_tile_rows = [tiles_across](VkPipeline pipeline, const PixelRect& part) {
    return on_lines(pipeline, part.top / kTileSide * tiles_across, part.bottom / kTileSide * tiles_across);
  };
  // The moving average runs along whole rows and columns, the other filters on tiles.
  const bool mean = keys.filter_rows.shader == Shader::kMeanRows;
  const LightStep steps[] = {
      on_tile_rows(pipelines.fixed(Shader::kTileDepthRange), parts.changed),
      on_tile_rows(pipelines.fixed(Shader::kCleanupTiles), parts.uneven),
      on_tiles(pipelines.fixed(Shader::kIslands), parts.cleaned),
      on_tiles(pipelines.fixed(Shader::kHoles), parts.filled),
      mean ? on_lines(*rows, parts.rows.top, parts.rows.bottom) : on_tiles(*rows, parts.rows),
      mean ? on_lines(*columns, parts.smooth.left, parts.smooth.right) : on_tiles(*columns, parts.smooth),
      on_lines(pipelines.fixed(Shader::kMapTotals), 0, static_cast<int>(size_.height))};
  for (const LightStep& step : steps) steps_.add(step);
  return {};
}

/// Another number of steps of the light takes another time.
void LightPass::note_light_steps() {
  const std::size_t light_steps = steps_.count_of(Stage::kLight);
  if (light_steps != measured_light_steps_) step_ms_[static_cast<std::size_t>(Stage::kLight)] = 0;
  measured_light_steps_ = light_steps;
}

/// The steps of the light and of pass 3.
Result<void> LightPass::add_light_steps(const LightKeys& keys, const Scene& scene) {
  if (here_.on()) {
    here_.add_light_steps(steps_, keys, regions_,
                          {.size = size_,
                           .outlines = maps_due_.parameters.outline_radius > 0,
                           .diffusion_steps = diffusion_steps(scene)});
    note_light_steps();
    return {};
  }
  Pipelines& pipelines = recorder_.pipelines();
  // Of half the picture's width and height.
  for (const auto& key : {keys.soft_light, keys.scatter_rows, keys.scatter_columns}) {
    if (!key) continue;
    const auto pipeline = pipelines.get(*key);
    if (!pipeline) return pipeline.error();
    steps_.add({.pipeline = *pipeline,
                .groups_across = groups(size_.width, 2 * kTileSide),
                .groups_down = groups(size_.height, 2 * kTileSide),
                .stage = Stage::kLight});
  }
  const auto lit = pipelines.get(keys.light);
  if (!lit) return lit.error();
  LightStep light_step = on_tiles(*lit, regions_.lit);
  light_step.stage = Stage::kLight;
  steps_.add(light_step);
  note_light_steps();
  int done = 0;
  const auto add = [&](Shader shader, const PixelRect& part) {
    LightStep step = on_tiles(pipelines.fixed(shader), part);
    step.stage = Stage::kFinish;
    step.order = LightSteps::order_after(done++);
    steps_.add(step);
  };
  if (maps_due_.parameters.outline_radius > 0) add(Shader::kOutline, regions_.outlined);
  for (int step = 0; step < diffusion_steps(scene); ++step) add(Shader::kDiffuse, regions_.finished);
  add(Shader::kFinish, regions_.finished);
  return {};
}

void LightPass::take_size(PictureSize size) {
  if (size == size_) return;
  size_ = size;
  step_ms_ = {};
}

Result<void> LightPass::begin(const Scene& scene, const Earlier& earlier, const Seam* seam) {
  const LightKeys keys = light_keys(scene);
  learn_step_times();
  take_size(*scene.size);
  shaders::LightParameters parameters = light_parameters(scene, size_, farthest_mm_);
  // Without weights all count the same: the next volume's picture will have them.
  if (!input_.weighted) parameters.confidence_counts = 0;
  recorder_.reset_times();
  here_.begin(keys);
  steps_.clear();
  steady_steps_ = 0;
  is_first_of_cast_ = is_new_cast_;
  const bool ends_seam = seam == nullptr && filtered_temporal_ == FANLIGHT_TEMPORAL_SEAM;
  const bool filters = is_new_input_ || filter_ != scene.filter || ends_seam;
  // Without the filter the maps stay those of the last one, whatever it would be now.
  const int temporal = filters ? take_earlier(scene, earlier, seam) : filtered_temporal_;
  if (!filters) parameters.confidence_counts = filtered_.confidence_counts;
  choose_regions(scene, temporal, parameters);
  memory_.parameters.mapped_as<shaders::LightParameters>() = parameters;
  if (filters) {
    if (auto added = add_filter_steps(keys); !added) return added;
    if (filter_due_ != scene.filter) step_ms_[static_cast<std::size_t>(Stage::kFilter)] = 0;
    filter_due_ = scene.filter;
    filter_.reset();
    new_frames_due_ = seam != nullptr ? seam->frames.count() : 0;
    motor_turned_ = seam != nullptr && seam->frames.turned();
    map_before_pixels_ = seam != nullptr ? seam->earlier.place.size.pixels() : 0;
    surface_id_ = next_surface_id();
  }
  return add_light_steps(keys, scene);
}

Result<void> LightPass::change(const Scene& scene) {
  auto& parameters = memory_.parameters.mapped_as<shaders::LightParameters>();
  shaders::LightParameters changed = light_parameters(scene, size_, farthest_mm_);
  // What begin() knew besides the scene.
  changed.confidence_counts = parameters.confidence_counts;
  maps_due_ = {
      .parameters = changed, .diffusion_steps = diffusion_steps(scene), .temporal = maps_due_.temporal};
  // Another light changes pixels that keep their depth.
  regions_.lit = regions_.outlined = regions_.finished = LightRegions::whole(size_).lit;
  set_smooth_part(changed, regions_.smooth);
  parameters = changed;
  steps_.drop_from(Stage::kLight);
  const LightKeys keys = light_keys(scene);
  here_.change(keys);
  return add_light_steps(keys, scene);
}

void LightPass::record_clear_totals(VkCommandBuffer commands) const {
  const shaders::MapTotals none{.min_depth = std::bit_cast<std::uint32_t>(kFarthestMm)};
  vkCmdUpdateBuffer(commands, memory_.map_totals.get(), 0, sizeof none, &none);
  barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

void LightPass::record_steps(VkCommandBuffer commands, std::size_t end_step) const {
  for (std::size_t index = steps_.next(); index < end_step; ++index) {
    const LightStep& step = steps_[index];
    const bool first_of_stage = index == 0 || steps_[index - 1].stage != step.stage;
    if (first_of_stage && step.stage == Stage::kFilter) {
      recorder_.stamp(GpuTimestamps::kFilterBegin);
      record_clear_totals(commands);
    }
    if (first_of_stage && step.stage == Stage::kLight) recorder_.stamp(GpuTimestamps::kLightBegin);
    if (first_of_stage && step.stage == Stage::kFinish) recorder_.stamp(GpuTimestamps::kLightEnd);
    if (index == steps_.next() || steps_[index - 1].order != step.order)
      recorder_.descriptors().bind(commands, step.order);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, step.pipeline);
    vkCmdDispatchBase(commands, step.first_across, step.first_down, 0, step.groups_across, step.groups_down,
                      1);
    pass_barrier(commands);
  }
}

void LightPass::record_read_back(VkCommandBuffer commands) const {
  // Of the maps of pass 1 too, which may be a copy.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT,
          VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT,
          VK_ACCESS_2_TRANSFER_READ_BIT);
  recorder_.stamp(GpuTimestamps::kFinishEnd);
  static_assert(sizeof(float) == sizeof(std::uint32_t));
  const VkBufferCopy map{.size = pixels() * sizeof(std::uint32_t)};
  vkCmdCopyBuffer(commands, memory_.finished.get(), memory_.read_back.get(), 1, &map);
  vkCmdCopyBuffer(commands, memory_.smooth_depth.get(), memory_.read_back_depth.get(), 1, &map);
  // Not again for a light that moved. A copy by the host is read where it is.
  if (is_new_input_ && config_.copies != Copies::kByHost)
    vkCmdCopyBuffer(commands, named_colours_, memory_.read_back_colours.get(), 1, &map);
  const VkBufferCopy totals{.size = memory_.read_back_totals.bytes()};
  vkCmdCopyBuffer(commands, memory_.map_totals.get(), memory_.read_back_totals.get(), 1, &totals);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT,
          VK_ACCESS_2_HOST_READ_BIT);
  recorder_.stamp(GpuTimestamps::kReadBackEnd);
}

/// Notes what the picture has changed, while its frames are blended.
void LightPass::note_changed_part() {
  ChangedPart& last = changed_parts_.front();
  if (last.new_frames != new_frames_) {
    std::shift_right(changed_parts_.begin(), changed_parts_.end(), 1);
    last = {.part = {}, .new_frames = new_frames_};
  }
  last.part = last.part.united(changed_);
  // Frames that are replaced twice are blended longer.
  if (motor_turned_) last.part = last.part.united(changed_by_blending(filter_due_->seam_frames));
  changed_ = {};
}

/// Copies the map of the last picture to where the temporal filter reads it.
void LightPass::record_map_before(VkCommandBuffer commands) const {
  const VkBufferCopy map{.size = map_before_pixels_ * sizeof(glm::vec2)};
  vkCmdCopyBuffer(commands, memory_.steady.get(), followed_, 1, &map);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT,
          VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

/// Submits the steps before end_step that were not submitted yet, and after the last one the read-back.
Result<void> LightPass::submit(std::size_t end_step) {
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  recorder_.begin_piece(steps_[steps_.next()].stage);
  // The filter of the volume before may run just before this one, and reads its buffers.
  barrier(*commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT);
  if (maps_to_copy_ != nullptr) copies_.copy(*commands, *maps_to_copy_, size_);
  if (blends() && steps_.next() == 0 && steady_steps_ > 0) record_map_before(*commands);
  record_steps(*commands, end_step);
  if (end_step == steps_.count()) record_read_back(*commands);
  if (here_.on()) {
    // It ends the filter's time: the processor measures the rest of it.
    if (is_here(end_step) && end_step > steps_.next()) recorder_.stamp(GpuTimestamps::kLightBegin);
    host_barrier(*commands);
  }
  if (auto submitted = recorder_.submit(recorder_.gpu().light_queue(), written_); !submitted)
    return submitted;
  maps_to_copy_ = nullptr;
  awaits_maps_ = false;
  note_submitted(end_step);
  return {};
}

/// Runs the steps before end_step that were not run yet on the processor, and after the last one the
/// read-back.
Result<void> LightPass::light_here(std::size_t end_step) {
  if (steps_[steps_.next()].here == shading::Step::kTake && reader_ != nullptr) {
    // Rare: another filter for the picture on show, while the next one is averaged with it.
    if (auto waited = reader_->wait(kReaderNs); !waited) return waited;
    if (reader_->outstanding() > 0) return {};
  }
  here_.run(steps_, steps_.next(), end_step, memory_);
  if (end_step == steps_.count()) {
    // Not again for a light that moved. A copy by the host is read where it is.
    const bool new_colours = is_new_input_ && config_.copies != Copies::kByHost;
    here_.read_back(memory_, size_, new_colours);
  }
  note_submitted(end_step);
  return {};
}

void LightPass::note_submitted(std::size_t end_step) {
  if (steps_.next() == 0 && end_step > 0 && steady_steps_ > 0) {
    new_frames_ = new_frames_due_;
    filtered_temporal_ = maps_due_.temporal;
  }
  steps_.submit_until(end_step);
  if (!steps_.submitted()) return;
  // Only now: after an error, or where the picture was given up, the next one does all of it.
  filter_ = filter_due_;
  maps_ = maps_due_;
  filtered_ = maps_due_.parameters;
  note_changed_part();
  is_new_cast_ = is_new_input_ = false;
}

/// The colours of pass 1, packed RGBA8, of the last picture's maps.
std::span<const std::uint8_t> LightPass::colours() const {
  return config_.copies == Copies::kByHost ? copies_.colour.mapped() : memory_.read_back_colours.mapped();
}

void LightPass::read_picture(const PictureStamp& stamp, Picture& to) const {
  // A picture whose light alone has moved: a megabyte or more need not be copied again.
  const bool has_surface = to.stamp.surface_id == surface_id_ && to.depth_mm.size() == pixels();
  to.stamp = stamp;
  to.stamp.surface_id = surface_id_;
  to.stamp.surface_share = surface_share();
  to.stamp.uncertain_share = uncertain_share();
  to.stamp.steady_share = steady_share();
  to.stamp.mean_volumes = mean_volumes();
  to.width = size_.width;
  to.height = size_.height;
  const auto rgba = memory_.read_back.mapped().first(4 * pixels());
  to.rgba.assign(rgba.begin(), rgba.end());
  if (has_surface) return;
  to.depth_mm.assign(depth_mm().begin(), depth_mm().end());
  to.certainty.resize(pixels());
  // By whole words: the compiler packs many at a time.
  const auto* const words = reinterpret_cast<const std::uint32_t*>(colours().data());
  std::uint8_t* const certainties = to.certainty.data();
  for (std::size_t pixel = 0; pixel < to.certainty.size(); ++pixel)
    certainties[pixel] = static_cast<std::uint8_t>(words[pixel] >> 24U);
}

/// Share of the picture's pixels that have a surface.
double LightPass::surface_share() const {
  return static_cast<double>(memory_.read_back_totals.mapped_as<shaders::MapTotals>().surface_pixels) /
         static_cast<double>(pixels());
}

/// Of these, the share whose surface is uncertain and dimmed: it stands out from the speckle by little
/// (surface_place.h), or fills a hole. 0 where nothing is dimmed: in modes that do not light the surface, and
/// where the speckle is not known.
double LightPass::uncertain_share() const {
  const auto& totals = memory_.read_back_totals.mapped_as<shaders::MapTotals>();
  if (filtered_.show != FANLIGHT_SHOW_SURFACE || totals.surface_pixels == 0) return 0;
  return static_cast<double>(totals.uncertain_pixels) / totals.surface_pixels;
}

/// Of the pixels that have a surface, the share whose depth is a mean over volumes; and the mean number of
/// these.
double LightPass::steady_share() const {
  const auto& totals = memory_.read_back_totals.mapped_as<shaders::MapTotals>();
  if (totals.surface_pixels == 0) return 0;
  return static_cast<double>(totals.steady_pixels) / totals.surface_pixels;
}

double LightPass::mean_volumes() const {
  const auto& totals = memory_.read_back_totals.mapped_as<shaders::MapTotals>();
  if (totals.steady_pixels == 0) return 1;
  return totals.volumes / (FANLIGHT_VOLUME_UNITS * static_cast<double>(totals.steady_pixels));
}

std::array<StageSpan, kStages> LightPass::stage_spans() const {
  auto spans = recorder_.stage_spans();
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    const StageSpan& here = here_.spans()[stage];
    if (here.begin_ns == 0) continue;
    if (spans[stage].begin_ns == 0) spans[stage].begin_ns = here.begin_ns;
    spans[stage].end_ns = here.end_ns;
  }
  return spans;
}

std::array<double, kStages> LightPass::stage_ms() const {
  auto ms = recorder_.stage_ms();
  for (std::size_t stage = 0; stage < kStages; ++stage) ms[stage] += here_.ms()[stage];
  return ms;
}

Result<void> LightPass::submit_next() {
  const Stage next = steps_[steps_.next()].stage;
  const bool here = is_here(steps_.next());
  // The processor reads maps that the GPU writes or copies.
  if (here && awaits_maps_) return submit(steps_.next());
  // Only a changed light is waited for here, and it comes too late for this picture once its light is begun.
  if (in_pieces() && !config_.pauses && next != Stage::kFilter) {
    return here ? light_here(steps_.count()) : submit_all();
  }
  const auto stage = static_cast<std::size_t>(next);
  const double known_ms = step_ms_[stage];
  const double whole_ms = known_ms > 0 ? known_ms : kPieceMs;
  const double share = static_cast<double>(regions_.smooth.pixels()) / static_cast<double>(pixels());
  const double step_ms = next == Stage::kFilter ? share * whole_ms : whole_ms;
  std::size_t end = std::max(steps_.end_of_piece(step_ms, kPieceMs), steady_steps_);
  // One piece is the GPU's or the processor's.
  for (std::size_t step = steps_.next(); step < end; ++step) {
    if (is_here(step) != here) end = step;
  }
  return here ? light_here(end) : submit(end);
}

}  // namespace fanlight
