// SPDX-License-Identifier: Apache-2.0
#include "renderer/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "proto/base/clock.hpp"
#include "renderer/renderer_errors.hpp"

namespace fanlight {

namespace {

// While both devices work, how long one of them is waited for before the other is looked at.
constexpr std::int64_t kBothDevicesNs = 1'000'000;

constexpr std::int64_t kSettlePollNs = 10'000'000;

}  // namespace

Result<Renderer::AllPipelines> Renderer::pipelines_of(PipelineStore& store, const Dependencies& dependencies,
                                                      const Pipelines::Config& config) {
  if (dependencies.light_gpu == nullptr || dependencies.light_gpu == &dependencies.gpu) {
    auto pipelines = store.get(dependencies.gpu, config);
    if (!pipelines) return pipelines.error();
    return AllPipelines(*std::move(pipelines), nullptr);
  }
  // The driver has one cache file, which the pipelines of pass 1 fill.
  return store.get({dependencies.gpu, config},
                   {*dependencies.light_gpu, {.sampling = config.sampling, .cache = {}}});
}

Result<std::unique_ptr<Renderer>> Renderer::create(const Config& config, const Dependencies& dependencies,
                                                   const NumberedScene& scene) {
  const Gpu& gpu = dependencies.gpu;
  if (auto fits = check_sizes(config.size, config.largest(), gpu.limits()); !fits) return fits.error();
  const std::uint32_t longest_side =
      std::max({config.geometry.columns, config.geometry.rows, config.frame_capacity});
  CastMeans means(gpu, config.sampling, longest_side, config.rays_by_shader);
  if (config.band_samples) means.band_samples = *config.band_samples;
  // What the processor runs itself needs no other device, and no pipelines.
  Dependencies used = dependencies;
  if (means.casts_here) used.light_gpu = nullptr;
  PipelineStore own;
  PipelineStore& store = used.store != nullptr ? *used.store : own;
  auto pipelines = pipelines_of(
      store, used, {.sampling = means.sampling, .lights = !means.casts_here, .cache = config.pipeline_cache});
  if (!pipelines) return pipelines.error();
  std::unique_ptr<Renderer> made(new Renderer(config, used, scene, *std::move(pipelines), std::move(means)));
  if (auto slots = made->create_slots(); !slots) return slots.error();
  made->pipelines_->save_cache();
  return made;
}

Result<void> Renderer::create_slots() {
  const PassDevice light{.gpu = &light_gpu_, .pipelines = light_pipelines_.get()};
  for (auto& state : slots_) {
    auto slot = VolumeInFlight::create(
        {.gpu = &gpu_, .pipelines = pipelines_.get()},
        {.size = config_.size,
         .largest = config_.largest(),
         .geometry = config_.geometry,
         .first_angle_rad = config_.first_angle_rad,
         .last_angle_rad = config_.last_angle_rad,
         .frame_capacity = config_.frame_capacity,
         .usual_frames = config_.usual_frames > 0 ? config_.usual_frames : config_.frame_capacity,
         .band_samples = means_.band_samples,
         .skipping = config_.skipping,
         .counting = config_.counting,
         .sampling = means_.sampling,
         .workers = means_.workers.get(),
         .ray_workers = means_.ray_workers()},
        on_one_device() ? nullptr : &light);
    if (!slot) {
      return too_large(slot.error(), gpu_.candidate().name,
                       config_.geometry.frame_bytes() * config_.frame_capacity);
    }
    if (auto ready = slot->prepare(scene_in_force().scene); !ready) return ready.error();
    state.reset(new SlotState{
        .slot = std::move(*slot), .cast_scene = {}, .lit_scene = {}, .stamp = {}, .filtered_view = {}});
  }
  slots_[0]->slot.follow(slots_[1]->slot);
  slots_[1]->slot.follow(slots_[0]->slot);
  return {};
}

void Renderer::show(const NumberedScene& scene) {
  scenes_.want(scene);
  if (size_of(scene.scene, config_.size).pixels() <= config_.largest().pixels()) return;
  NumberedScene usual = scene;
  usual.scene.size.reset();
  scenes_.want(usual);
}

MainStatus Renderer::status() const {
  const auto status_of = [this](const SlotState& state) {
    return SlotStatus{.phase = state.phase,
                      .loaded = state.slot.loaded(),
                      .outstanding = state.slot.outstanding() > 0,
                      .light_outstanding = state.slot.light_outstanding() > 0,
                      .light_begun = state.slot.light_begun(),
                      .light_submitted = state.slot.light_submitted(),
                      .read_by_private_view = private_.reads(state.slot),
                      .cast_submitted = state.slot.cast_submitted(),
                      .cast_nearly_submitted = state.slot.cast_nearly_submitted(),
                      .gave_up_cast = state.gave_up_cast,
                      .refines = state.refines,
                      .map_lost = state.map_lost,
                      .frames_changed = state.slot.changed(),
                      .can_recast = state.slot.can_recast(),
                      .frames_staged = state.slot.frames_staged(),
                      .cast_scene = &state.cast_scene,
                      .lit_scene = &state.lit_scene};
  };
  return {.slots = {status_of(*slots_[0]), status_of(*slots_[1])},
          .newest = newest_,
          .shown = shown_,
          .runs_here = means_.casts_here};
}

Result<void> Renderer::load(const Volume& volume, Loading loading) {
  thread_owner_.check();
  const auto commit_numbers = volume.commit_numbers();
  newest_commit_number_ = commit_numbers.empty() ? 0 : *std::ranges::max_element(commit_numbers);
  const EchoLevels measured = loading == Loading::kKept ? EchoLevels{} : measured_levels(volume);
  const bool other = loading != Loading::kKept && levels_.is_other(measured);
  if (other) levels_.add(measured);
  find_near_tissue_of(volume, loading);
  // A volume that does not fit takes the other slot, so that a refusal leaves the shown picture.
  const bool completes = replaces_frames() && slots_[newest_]->slot.suits(volume);
  auto loaded = completes ? complete_newest(volume, loading) : load_into_other(volume, loading);
  if (loaded) {
    const std::uint64_t bytes = volume.geometry().frame_bytes() * volume.stamp().frames;
    largest_volume_bytes_ = std::max(largest_volume_bytes_, bytes);
  }
  // For the next volume, whose first frames pass 0 prepares before the last ones come.
  if (!other && loading != Loading::kKept) levels_.add(measured);
  return loaded;
}

void Renderer::find_near_tissue_of(const Volume& volume, Loading loading) {
  // Only where it is asked for: it reads the whole volume.
  const Scene::Near& wanted = scene_in_force().scene.near;
  near_tissue_ = search_near_tissue(volume, levels(), wanted);
  if (loading != Loading::kKept) steady_near_tissue_.add(near_tissue_, wanted, volume.geometry());
}

Result<void> Renderer::load_into_other(const Volume& volume, Loading loading) {
  SlotState& next = *slots_[1 - newest_];
  next.awaits_picture = loading == Loading::kNew;
  if (auto loaded = next.slot.load(volume, levels(), near_tissue_); !loaded) {
    if (is_breakage(loaded.error())) return loaded;
    next.awaits_picture = false;
    if (loading == Loading::kNew) counters_.volumes_refused.add();
    return loaded;
  }
  if (SlotState& refined = *slots_[newest_]; refined.phase == WorkPhase::kCasting) {
    refined.phase = WorkPhase::kIdle;
    refined.map_lost = true;
  }
  newest_ = 1 - newest_;
  next.is_kept = loading == Loading::kKept;
  auto begun = as_breakage(begin_cast(next));
  next.refines = false;  // also where the slot has shown this volume before
  return begun;
}

Result<void> Renderer::complete_newest(const Volume& volume, Loading loading) {
  SlotState& state = *slots_[newest_];
  if (std::exchange(state.awaits_picture, loading == Loading::kNew)) counters_.volumes_skipped.add();
  if (auto completed = state.slot.complete(volume, levels(), near_tissue_); !completed) {
    if (is_breakage(completed.error())) return completed;
    state.awaits_picture = false;
    if (loading == Loading::kNew) counters_.volumes_refused.add();
    return completed;
  }
  state.is_kept = loading == Loading::kKept;
  if (loading != Loading::kNew) state.slot.end_seam();
  if (!state.slot.changed()) return as_breakage(light(state));
  return as_breakage(state.slot.can_recast() ? recast(state) : begin_cast(state));
}

void Renderer::take_frame(const QueuedFrame& frame) {
  thread_owner_.check();
  // The frame waited in the queue while its volume, or a newer one, was loaded.
  if (frame.stamp.commit_number != 0 && frame.stamp.commit_number <= newest_commit_number_) return;
  if (replaces_frames()) {
    VolumeInFlight& slot = slots_[newest_]->slot;
    // The mismatch correction has opposite signs for the two sweep directions.
    const VolumeStamp& last = slot.volume();
    const double correction_rad =
        frame.stamp.direction == last.direction ? last.angle_correction_rad : -last.angle_correction_rad;
    const double angle_rad = frame.stamp.angle_rad + correction_rad;
    slot.replace(frame, slot.nearest_frame_index(angle_rad), angle_rad);
    return;
  }
  const VolumeInFlight& newest = slots_[newest_]->slot;
  slots_[1 - newest_]->slot.stage(frame.geometry, newest.nearest_frame_index(frame.stamp.angle_rad),
                                  static_cast<std::uint32_t>(newest.angles_rad().size()),
                                  frame.stamp.commit_number, frame.pixels);
}

void Renderer::count_cast(SlotState& state) {
  state.phase = WorkPhase::kCasting;
  counters_.pass1_runs.add();
  state.cast_number = counters_.pass1_runs.value();
}

Result<void> Renderer::begin_cast(SlotState& state) {
  auto begun = begin_cast_of_scene(state);
  return begun || !falls_back(begun.error()) ? begun : begin_cast_of_scene(state);
}

/// Whether a cast that begins now makes the picture of the slot finer, and changes nothing else.
bool Renderer::would_refine(const SlotState& state) const {
  // Not the restart of a cast: the picture is of another view then.
  if (state.phase != WorkPhase::kIdle || state.map_lost) return false;
  const VolumeStamp& lit = state.stamp.volume;
  const VolumeStamp& loaded = state.slot.volume();
  return lit.volume_id == loaded.volume_id && lit.last_frame_sequence == loaded.last_frame_sequence &&
         differs_in_size_alone(state.cast_scene.scene, scene_in_force().scene) &&
         size_of(state.cast_scene.scene, config_.size).pixels() <
             size_of(scene_in_force().scene, config_.size).pixels();
}

Result<void> Renderer::begin_cast_of_scene(SlotState& state) {
  if (auto begun = state.slot.begin_cast(scene_in_force().scene); !begun) return begun;
  if (state.slot.filter_left_out()) counters_.volumes_unfiltered.add();
  state.refines = would_refine(state);
  state.map_lost = false;
  state.cast_scene = scene_in_force();
  scenes_.note_begun();
  count_cast(state);
  return {};
}

Result<void> Renderer::recast(SlotState& state) {
  if (auto cast = state.slot.recast(state.cast_scene.scene); !cast) return cast;
  state.refines = false;
  count_cast(state);
  return {};
}

Result<void> Renderer::advance(NewWork new_work, NextVolume next) {
  thread_owner_.check();
  if (auto retried = retry_held(); !retried) return retried;
  if (new_work == NewWork::kWaits && !main_busy()) return known_fault();
  scenes_.try_again(now_ns());
  MainStatus now = status();
  now.volume_waits = next == NextVolume::kWaits;
  const MainSteps due = decide(now, scene_in_force());
  if (auto sound = known_fault(); !sound) return sound;
  for (const MainStep step : due.steps()) {
    if (auto done = execute(step); !done) return done;
  }
  return {};
}

Result<void> Renderer::execute(MainStep step) {
  SlotState& newest = *slots_[newest_];
  switch (step) {
    case MainStep::kBeginCast:
      return begin_cast(newest);
    case MainStep::kRestartCast: {
      auto begun = begin_cast(newest);
      if (begun) newest.gave_up_cast = true;
      return begun;
    }
    case MainStep::kLightShown:
      return light(*slots_[shown_]);
    case MainStep::kRecast:
      return recast(newest);
    case MainStep::kCastBand:
      return newest.slot.cast_next_band();
    case MainStep::kLightCast:
      return light(newest);
    case MainStep::kLightPiece:
      return submit_light_piece(newest);
    case MainStep::kLightPieceOfOther:
      return submit_light_piece(*slots_[1 - newest_]);
    case MainStep::kPrepareAhead:
      return prepare_ahead();
  }
  return {};
}

Result<void> Renderer::prepare_ahead() {
  VolumeInFlight& slot = slots_[1 - newest_]->slot;
  auto begun = slot.prepare_ahead(scene_in_force().scene, levels());
  if (!begun && !falls_back(begun.error())) return begun.error();
  return {};
}

bool Renderer::collect(Picture& picture) {
  thread_owner_.check();
  // Asked of the newer volume first: the older one's light is submitted before it, so that it is done too
  // where the newer one's is. Asked the other way round, both may end in between, and the older picture be
  // skipped.
  const auto is_lit = [this](std::size_t index) {
    const SlotState& state = *slots_[index];
    return state.phase == WorkPhase::kLighting && state.slot.light_submitted() &&
           state.slot.light_outstanding() == 0;
  };
  const bool newest_is_lit = is_lit(newest_);
  const bool older_is_lit = is_lit(1 - newest_);
  // The older volume first, so that its picture is shown where both are done.
  for (const std::size_t index : {1 - newest_, newest_}) {
    if (!(index == newest_ ? newest_is_lit : older_is_lit)) continue;
    SlotState& state = *slots_[index];
    const auto stage_ms = state.slot.stage_ms();
    if (devices_.fault() != nullptr)
      return false;  // what a lost GPU has left in the memory may be an old picture
    state.phase = WorkPhase::kIdle;
    const bool first = std::exchange(state.awaits_picture, false);
    if (state.stamp.volume.volume_id < shown_volume_id_ && !state.is_kept) {
      counters_.pictures_outdated.add();
      if (first) counters_.volumes_skipped.add();
      continue;
    }
    shown_ = index;
    shown_volume_id_ = state.stamp.volume.volume_id;
    state.stamp.picture_id = ++pictures_;
    state.stamp.stage_ms = stage_ms;
    state.stamp.passes_overlap = !on_one_device();
    state.stamp.finished_time_ns = now_ns();
    counters_.pictures_finished.add();
    state.slot.read_picture(state.stamp, picture);
    if (first) counters_.volumes_rendered.add();
    return true;
  }
  return false;
}

Result<bool> Renderer::advance_private() {
  thread_owner_.check();
  return !busy() && private_views_have_input() ? private_.advance(shown_for_private_views()) : false;
}

bool Renderer::private_due() const {
  return private_views_have_input() && private_.due(shown_for_private_views());
}

bool Renderer::private_views_have_input() const {
  const SlotState& shown = *slots_[shown_];
  return shown.slot.loaded() && !shown.map_lost && shown.cast_number != 0 &&
         !view_changed(shown.cast_scene, scene_in_force());
}

PrivateRenderer::Shown Renderer::shown_for_private_views() const {
  SlotState& shown = *slots_[shown_];
  return {.slot = shown.slot,
          .previous = slots_[1 - shown_]->slot,
          .cast_scene = shown.cast_scene.scene,
          .cast_number = shown.cast_number,
          .earlier = earlier_than(shown),
          .usual_size = config_.size};
}

bool Renderer::main_busy() const {
  return std::ranges::any_of(slots_, [this](const auto& state) {
    // The weights that a private view waits for are on the slot's timeline.
    const bool is_private = state->slot.light_outstanding() == 0 && private_.reads(state->slot);
    return state->phase != WorkPhase::kIdle || (state->slot.outstanding() > 0 && !is_private);
  });
}

Result<void> Renderer::wait(std::int64_t timeout_ns) {
  thread_owner_.check();
  // Waits for one semaphore, that of the earliest submission of a device: Mesa waits for any of two
  // semaphores in a busy loop, which costs lavapipe half of two cores. With two queues the later submission
  // may finish first; timeout_ns bounds that delay.
  const SubmissionTimeline* earliest = nullptr;
  const SubmissionTimeline* lighting = nullptr;  // the same of passes 2 and 3 on their own device
  const auto consider = [](const SubmissionTimeline*& first, const SubmissionTimeline& timeline) {
    if (first == nullptr || timeline.submitted_ns() < first->submitted_ns()) first = &timeline;
  };
  for (const auto& state : slots_) {
    const VolumeInFlight& slot = state->slot;
    if (slot.cast_timeline().outstanding() > 0) consider(earliest, slot.cast_timeline());
    if (slot.light_outstanding() > 0) consider(on_one_device() ? earliest : lighting, slot.light_timeline());
  }
  if (const auto* const timeline = private_.outstanding_timeline()) consider(earliest, *timeline);
  // No call waits for semaphores of two devices.
  if (earliest != nullptr && lighting != nullptr) timeout_ns = std::min(timeout_ns, kBothDevicesNs);
  const SubmissionTimeline* const awaited = lighting != nullptr ? lighting : earliest;
  // A piece of pass 0 or 1 that the processor runs is done when it returns, and the next one is due.
  if (works_here()) timeout_ns = 0;
  if (awaited != nullptr) {
    if (auto waited = awaited->wait(static_cast<std::uint64_t>(timeout_ns)); !waited) {
      devices_.note_fault(Gpu::Condition::kLost, waited.error());
      return waited;
    }
  }
  return observe();
}

Result<DepthMaps> Renderer::read_depth() {
  thread_owner_.check();
  return slots_[shown_]->slot.read_depth();
}

// ---- passes 2 and 3 of the main view

/// The steady map of the other slot, if the temporal filter may use it.
VolumeInFlight::Earlier Renderer::earlier_than(const SlotState& state) const {
  if (replaces_frames()) return std::nullopt;  // a single slot is used, and it keeps no last volume
  const SlotState& other = *slots_[other_than(state)];
  const MappedVolume mapped{.id = other.filtered_volume_id, .is_kept = other.is_kept};
  const MappedVolume now{.id = state.slot.volume().volume_id, .is_kept = state.is_kept};
  if (!may_average(mapped, now)) return std::nullopt;
  return earlier_map(other.filtered_view, config_.size, state.cast_scene.scene, mapped.id >= now.id);
}

/// The view of the slot's own last picture, where frames are replaced one by one.
VolumeInFlight::Earlier Renderer::picture_before(const SlotState& state) const {
  const bool is_newest = &state == slots_[newest_].get();  // the other one's map is overwritten
  if (!is_newest || !replaces_frames() || state.filtered_volume_id == 0 ||
      !differs_in_view_alone(state.filtered_view, state.cast_scene.scene))
    return std::nullopt;
  return earlier_map(state.filtered_view, config_.size, state.cast_scene.scene, true);
}

Result<void> Renderer::light(SlotState& state) {
  // The shown volume goes without weights where another one is cast, whose picture will have them.
  const bool takes_time = state.phase == WorkPhase::kCasting || &state == slots_[newest_].get();
  const Scene scene = relit(state.cast_scene.scene, scene_in_force().scene);
  // A private view has asked for weights, and the host may not read them yet: the next call tries again.
  if (!state.slot.maps_are_written()) return {};
  if (!takes_time || !state.slot.weights_due(scene) || state.slot.outstanding() > 0)
    return submit_light(state);
  // A private view still reads the weights that this would overwrite.
  if (private_.reads(state.slot)) return {};
  if (auto added = state.slot.add_weights(scene); !added)
    return falls_back(added.error()) ? Result<void>{} : added;
  state.phase = WorkPhase::kCasting;  // the light follows when this is done
  return {};
}

void Renderer::take_light_scene(SlotState& state) const {
  state.lit_scene = {.revision = view_changed(state.cast_scene, scene_in_force()) ? state.cast_scene.revision
                                                                                  : scene_in_force().revision,
                     .scene = relit(state.cast_scene.scene, scene_in_force().scene)};
}

Result<void> Renderer::submit_light_piece(SlotState& state) {
  const Scene now = relit(state.cast_scene.scene, scene_in_force().scene);
  const bool same_filter = first_pass_changed(state.lit_scene.scene, now) > FirstPass::kFilter;
  const SlotStatus status{.cast_scene = &state.cast_scene, .lit_scene = &state.lit_scene};
  // The picture has no light yet: it gets the newest one. Another filter waits for the next picture: one that
  // never rests would begin this one again and again.
  if (state.slot.light_begun() || !same_filter || !light_changed(status, scene_in_force()))
    return state.slot.light_next_piece(nullptr);
  const NumberedScene before = state.lit_scene;
  take_light_scene(state);
  auto lit = state.slot.light_next_piece(&state.lit_scene.scene);
  if (!lit && falls_back(lit.error())) {
    state.lit_scene = before;
    return state.slot.light_next_piece(&state.lit_scene.scene);
  }
  if (!lit) return lit;
  note_light(state);
  return {};
}

Result<void> Renderer::submit_light(SlotState& state) {
  take_light_scene(state);
  if (auto lit = state.slot.light(state.lit_scene.scene, earlier_than(state), picture_before(state)); !lit) {
    // The next advance() lights it by the scene that is in force then.
    return falls_back(lit.error()) ? Result<void>{} : lit;
  }
  // It has overwritten the other slot's map.
  if (state.slot.blends()) slots_[other_than(state)]->filtered_volume_id = 0;
  state.filtered_volume_id = state.slot.volume().volume_id;
  state.filtered_view = state.cast_scene.scene;
  state.phase = WorkPhase::kLighting;
  state.gave_up_cast = false;
  counters_.pass2_runs.add();
  if (state.slot.lights_a_part()) counters_.pass2_parts.add();
  note_light(state);
  return {};
}

/// Notes what the picture will show: lit_scene, by the scene in force.
void Renderer::note_light(SlotState& state) {
  // The light of an older cast says nothing about a view that is still to be cast.
  if (!view_changed(state.cast_scene, scene_in_force())) scenes_.note_drawn();
  state.stamp = {.scene_revision = state.lit_scene.revision,
                 .pass1_runs = counters_.pass1_runs.value(),
                 .pass2_runs = counters_.pass2_runs.value(),
                 .deadline_level = scene_in_force().deadline.level,
                 .measures = state.cast_scene.deadline.measures,
                 .volume = state.slot.volume(),
                 .levels = state.slot.levels(),
                 .near_tissue = state.slot.near_tissue_state(state.cast_scene.scene),
                 .near_end_mm = state.slot.near_end_mm(state.cast_scene.scene),
                 .sample_distances = state.slot.sample_distances(state.cast_scene.scene),
                 .seam_frames = state.slot.blends() ? state.lit_scene.scene.filter.seam_frames : 0,
                 .view = picture_view(state.cast_scene.scene, size_of(state.cast_scene.scene, config_.size))};
  state.stamp.measures.cheap_filters = scene_in_force().deadline.measures.cheap_filters;
}

// ---- faults and the end

Renderer::~Renderer() {
  if (!given_up_) {
    const bool settled = settle(watchdog_.hung_after_ns());
    if (!settled && devices_.condition() == Gpu::Condition::kSound)
      devices_.note_fault(Gpu::Condition::kHung,
                          {ErrorCode::kLost, "the GPU did not finish its work at the end"});
    if (settled) pipelines_->save_cache();
    give_up();
  }
  if (!devices_.is_at_work()) return;
  // The GPU may still write to this memory, so it is left to the end of the process.
  for (auto& state : slots_) static_cast<void>(state.release());
  private_.leave_memory();
  // A reference that is never dropped: a store may hold the pipelines too.
  static_cast<void>(new (std::nothrow) std::array{pipelines_, light_pipelines_});
}

void Renderer::give_up() {
  if (std::exchange(given_up_, true)) return;
  for (const auto& state : slots_) {
    if (!state) continue;
    if (state->awaits_picture) counters_.volumes_skipped.add();
    if (state->phase == WorkPhase::kLighting && devices_.fault() != nullptr) counters_.pictures_lost.add();
  }
}

bool Renderer::settle(std::int64_t timeout_ns) {
  for (const auto& state : slots_) {
    if (state) state->slot.drop_held();
  }
  private_.drop_held();
  const std::int64_t deadline_ns = now_ns() + timeout_ns;
  while (devices_.fault() == nullptr) {
    const bool outstanding =
        private_.outstanding_timeline() != nullptr ||
        std::ranges::any_of(slots_, [](const auto& state) { return state && state->slot.outstanding() > 0; });
    const std::int64_t left_ns = deadline_ns - now_ns();
    if (!outstanding) return devices_.fault() == nullptr;
    if (left_ns <= 0 || !wait(std::min(left_ns, kSettlePollNs))) return false;
  }
  return false;
}

bool Renderer::falls_back(const Error& error) {
  return scenes_.falls_back(error, now_ns());
}

Result<void> Renderer::retry_held() {
  for (const auto& state : slots_) {
    if (auto retried = state->slot.retry_held(); !retried) return retried;
  }
  return private_.retry_held();
}

Result<void> Renderer::observe() {
  std::array<Watchdog::Lane, 4 + 2 * kMostPrivateViews> lanes;
  static_assert(lanes.size() <= Watchdog::kMostLanes);
  std::size_t next = 0;
  const auto add = [&](const SubmissionTimeline* timeline) {
    Watchdog::Lane& lane = lanes[next++];
    if (timeline != nullptr)
      lane = {.submissions = timeline->submissions(), .outstanding = timeline->outstanding() > 0};
  };
  for (const auto& state : slots_) {
    add(&state->slot.cast_timeline());
    add(&state->slot.light_timeline());
  }
  for (std::size_t view = 0; view < kMostPrivateViews; ++view) {
    for (const SubmissionTimeline* const timeline : private_.timelines(view)) add(timeline);
  }
  pace_ = watchdog_.observe(lanes, now_ns());
  if (pace_ == Watchdog::Pace::kHung) {
    devices_.note_fault(Gpu::Condition::kHung, not_finished_for(watchdog_.hung_after_ns()));
  }
  return known_fault();
}

}  // namespace fanlight
