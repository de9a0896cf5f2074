#include "renderer/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "proto/clock.hpp"
#include "renderer/vulkan_result.hpp"

namespace fanlight {

namespace {

// Samples in a band of pass 1: some 30 ms of work on lavapipe, and well under that on a GPU. A moved light,
// and the end of the process, wait for a band.
constexpr std::uint64_t kProcessorBand = 8'000'000;
constexpr std::uint64_t kGpuBand = 500'000'000;
// A private view's bands are smaller by this, since the main view waits for them.
constexpr std::uint64_t kPrivatePieces = 4;

Result<void> check_picture(const Renderer::Config& config, const VkPhysicalDeviceLimits& limits) {
  const std::uint32_t most_pixels = limits.maxStorageBufferRange / sizeof(glm::uvec2);
  const std::uint64_t pixels = std::uint64_t{config.size.width} * config.size.height;
  if (std::min(config.size.width, config.size.height) < 2 || pixels > most_pixels) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("a picture of {} x {} does not fit this GPU, expected 2 x 2 to {} pixels",
                             config.size.width, config.size.height, most_pixels)};
  }
  return {};
}

/// Where memory ran out, what would have been needed.
Error too_large(const Renderer::Config& config, const Gpu& gpu, const Error& error) {
  if (error.code != ErrorCode::kUnavailable) return error;
  const double volume_gb = static_cast<double>(config.geometry.frame_bytes() * config.frame_capacity) / 1e9;
  return {error.code,
          fmt::format("{} has no memory for two volumes of {:.2f} GB, each there and on its way ({}), "
                      "expected smaller ones",
                      gpu.candidate().name, volume_gb, error.message)};
}

}  // namespace

Result<std::unique_ptr<Renderer>> Renderer::create(const Config& config, const Dependencies& dependencies,
                                                   const NumberedScene& scene) {
  const Gpu& gpu = dependencies.gpu;
  if (auto fits = check_picture(config, gpu.limits()); !fits) return fits.error();
  const bool processor = gpu.candidate().kind == kProcessorKind;
  const Sampling sampling = config.sampling.value_or(processor ? Sampling::kGathering : Sampling::kTexture);
  const std::uint64_t band_samples = processor ? kProcessorBand : kGpuBand;
  auto passes = Passes::create(gpu, sampling);
  if (!passes) return passes.error();
  std::unique_ptr<Renderer> made(new Renderer(
      config, dependencies, scene, std::move(*passes),
      {.size = config.size, .band_samples = band_samples / kPrivatePieces, .skipping = config.skipping}));

  for (auto& flight : made->flights_) {
    auto slot = RenderSlot::create(
        gpu, *made->passes_,
        {.size = config.size,
         .geometry = config.geometry,
         .first_angle_rad = config.first_angle_rad,
         .last_angle_rad = config.last_angle_rad,
         .frame_capacity = config.frame_capacity,
         .usual_frames = config.usual_frames > 0 ? config.usual_frames : config.frame_capacity,
         .band_samples = band_samples,
         .skipping = config.skipping,
         .sampling = sampling});
    if (!slot) return too_large(config, gpu, slot.error());
    if (auto ready = slot->prepare(gpu, *made->passes_, scene.scene); !ready) return ready.error();
    flight.reset(new Flight{
        .slot = std::move(*slot), .cast_scene = {}, .lit_scene = {}, .stamp = {}, .filtered_view = {}});
  }
  made->flights_[0]->slot.follow(gpu, made->flights_[1]->slot);
  made->flights_[1]->slot.follow(gpu, made->flights_[0]->slot);
  return made;
}

Renderer::~Renderer() {
  vkDeviceWaitIdle(gpu_.device());
  for (const auto& flight : flights_) {
    if (flight && flight->awaits_picture) counters_.volumes_skipped.add();
  }
}

bool Renderer::wants_volume() const {
  const bool casting =
      std::ranges::any_of(flights_, [](const auto& flight) { return flight->phase == Phase::kCasting; });
  // Where frames roll, a volume may take either slot.
  const auto is_free = [this](const Flight& flight) {
    return flight.phase == Phase::kIdle && settled(flight);
  };
  return !casting && is_free(*flights_[1 - newest_]) && (!rolls() || is_free(*flights_[newest_]));
}

Result<void> Renderer::load(const Volume& volume) {
  const auto arrivals = volume.arrivals();
  newest_arrival_ = arrivals.empty() ? 0 : *std::ranges::max_element(arrivals);
  // One that does not fit takes the other slot, so that a refusal leaves what is shown.
  if (rolls() && flights_[newest_]->slot.suits(volume)) return complete(volume);
  Flight& next = *flights_[1 - newest_];
  next.awaits_picture = true;
  if (auto loaded = next.slot.load(gpu_, volume); !loaded) {
    if (loaded.error().code == ErrorCode::kBroken) return loaded;
    next.awaits_picture = false;
    counters_.volumes_refused.add();
    return {};
  }
  newest_ = 1 - newest_;
  return begin_cast(next);
}

bool Renderer::rolls() const {
  return scene_.scene.refresh == Refresh::kFrame && flights_[newest_]->slot.loaded() &&
         flights_[newest_]->cast_scene.scene.refresh == Refresh::kFrame;
}

Result<void> Renderer::complete(const Volume& volume) {
  Flight& flight = *flights_[newest_];
  if (std::exchange(flight.awaits_picture, true)) counters_.volumes_skipped.add();
  if (auto completed = flight.slot.complete(gpu_, volume); !completed) {
    if (completed.error().code == ErrorCode::kBroken) return completed;
    flight.awaits_picture = false;
    counters_.volumes_refused.add();
    return {};
  }
  if (!flight.slot.changed()) return light(flight);
  return flight.slot.can_recast() ? recast(flight) : begin_cast(flight);
}

Result<void> Renderer::recast(Flight& flight) {
  if (auto cast = flight.slot.recast(gpu_, *passes_, flight.cast_scene.scene); !cast) return cast;
  flight.phase = Phase::kCasting;
  counters_.pass1_runs.add();
  flight.cast = counters_.pass1_runs.value();
  return {};
}

std::size_t Renderer::next() const {
  return rolls() ? newest_ : 1 - newest_;
}

bool Renderer::wants_frame() const {
  // Places are guessed from the last volume's.
  const Flight& next = *flights_[this->next()];
  return flights_[newest_]->slot.loaded() && next.phase == Phase::kIdle && settled(next);
}

std::uint32_t Renderer::place_of(double angle_rad) const {
  const auto angles_rad = flights_[newest_]->slot.angles_rad();
  const auto above = std::ranges::lower_bound(angles_rad, angle_rad);
  if (above == angles_rad.begin()) return 0;
  const bool below_is_nearer = above == angles_rad.end() || angle_rad - above[-1] < *above - angle_rad;
  return static_cast<std::uint32_t>(above - angles_rad.begin()) - (below_is_nearer ? 1 : 0);
}

void Renderer::take_frame(const FedFrame& frame) {
  // One that waited in the feed while its volume was taken, or a newer one.
  if (frame.stamp.arrival != 0 && frame.stamp.arrival <= newest_arrival_) return;
  if (rolls()) {
    RenderSlot& slot = flights_[newest_]->slot;
    // The correction of the mismatch turns the sweeps of the one direction one way, of the other the other.
    const VolumeStamp& last = slot.volume();
    const double turn_rad =
        frame.stamp.direction == last.direction ? last.angle_correction_rad : -last.angle_correction_rad;
    const double angle_rad = frame.stamp.angle_rad + turn_rad;
    slot.replace(frame, place_of(angle_rad), angle_rad);
    return;
  }
  flights_[1 - newest_]->slot.stage(frame.geometry, place_of(frame.stamp.angle_rad),
                                    static_cast<std::uint32_t>(flights_[newest_]->slot.angles_rad().size()),
                                    frame.stamp.arrival, frame.pixels);
}

Result<void> Renderer::begin_cast(Flight& flight) {
  if (auto begun = flight.slot.begin_cast(gpu_, *passes_, scene_.scene); !begun) return begun;
  if (flight.slot.filter_left_out()) counters_.volumes_unfiltered.add();
  flight.cast_scene = scene_;
  flight.phase = Phase::kCasting;
  counters_.pass1_runs.add();
  flight.cast = counters_.pass1_runs.value();
  return {};
}

bool Renderer::view_changed(const Flight& flight) const {
  return first_pass_changed(flight.cast_scene.scene, scene_.scene) <= FirstPass::kCast;
}

RenderSlot::Past Renderer::past_of(const Flight& flight) const {
  if (rolls()) return RenderSlot::Past::kNone;  // there is one slot, and no last volume beside it
  const Flight& other = &flight == flights_[0].get() ? *flights_[1] : *flights_[0];
  const bool before =
      other.filtered_volume_id > 0 && other.filtered_volume_id < flight.slot.volume().volume_id;
  const bool same_view =
      before && first_pass_changed(other.filtered_view, flight.cast_scene.scene) > FirstPass::kCast;
  return same_view ? RenderSlot::Past::kKnown : RenderSlot::Past::kNone;
}

bool Renderer::light_changed(const Flight& flight) const {
  // With the view unchanged every new revision gets its picture, even one that went back to what is shown:
  // whoever asked for it waits for its number.
  if (!view_changed(flight) && flight.lit_scene.revision != scene_.revision) return true;
  const Scene possible = relit(flight.cast_scene.scene, scene_.scene);
  return first_pass_changed(flight.lit_scene.scene, possible) != FirstPass::kNone;
}

Result<void> Renderer::light(Flight& flight) {
  flight.lit_scene = {.revision = view_changed(flight) ? flight.cast_scene.revision : scene_.revision,
                      .scene = relit(flight.cast_scene.scene, scene_.scene)};
  if (auto lit = flight.slot.light(gpu_, *passes_, flight.lit_scene.scene, past_of(flight)); !lit) return lit;
  flight.filtered_volume_id = flight.slot.volume().volume_id;
  flight.filtered_view = flight.cast_scene.scene;
  flight.phase = Phase::kLighting;
  flight.gave_up_cast = false;
  counters_.pass2_runs.add();
  flight.stamp = {.scene_revision = flight.lit_scene.revision,
                  .pass1_runs = counters_.pass1_runs.value(),
                  .pass2_runs = counters_.pass2_runs.value(),
                  .deadline_level = scene_.deadline.level,
                  .measures = flight.cast_scene.deadline.measures,
                  .volume = flight.slot.volume(),
                  .view = picture_view(flight.cast_scene.scene, config_.size)};
  flight.stamp.measures.cheap_filters = scene_.deadline.measures.cheap_filters;
  return {};
}

Result<void> Renderer::advance() {
  Flight& newest = *flights_[newest_];
  if (newest.phase == Phase::kIdle && newest.slot.loaded() && settled(newest) && view_changed(newest)) {
    if (auto begun = begin_cast(newest); !begun) return begun;
  }
  // A cast for a view that nobody wants any more gives way, but not twice in a row: a camera that never rests
  // shall see pictures too.
  const bool unwanted = newest.phase == Phase::kCasting && !newest.slot.cast_submitted() &&
                        newest.slot.outstanding(gpu_) == 0 && view_changed(newest);
  if (unwanted && !newest.gave_up_cast) {
    if (auto begun = begin_cast(newest); !begun) return begun;
    newest.gave_up_cast = true;
  }
  // Before the next band, so that a moved light does not wait for it.
  Flight& shown = *flights_[shown_];
  if (shown.phase == Phase::kIdle && shown.slot.loaded() && light_changed(shown)) {
    if (auto submitted = light(shown); !submitted) return submitted;
  }
  if (rolls() && newest.phase == Phase::kIdle && settled(newest) && newest.slot.changed()) {
    return newest.slot.can_recast() ? recast(newest) : begin_cast(newest);
  }
  if (newest.phase == Phase::kCasting) {
    // A band waits for the one before it to be done, and the light for the last: what is submitted early
    // stands in the way of a moved light, or shows an old one.
    if (newest.slot.outstanding(gpu_) > 0) return {};
    return newest.slot.cast_submitted() ? light(newest) : newest.slot.cast_next_band(gpu_, *passes_);
  }
  return prepare_ahead();
}

Result<void> Renderer::prepare_ahead() {
  if (rolls() || !wants_frame()) return {};
  if (auto begun = flights_[1 - newest_]->slot.prepare_ahead(gpu_, *passes_, scene_.scene.speckle); !begun) {
    return begun.error();
  }
  return {};
}

bool Renderer::collect(Picture& picture) {
  // The older volume first, so that its picture is shown where both are done.
  for (const std::size_t index : {1 - newest_, newest_}) {
    Flight& flight = *flights_[index];
    if (flight.phase != Phase::kLighting || flight.slot.outstanding(gpu_) > 0) continue;
    flight.phase = Phase::kIdle;
    const bool first = std::exchange(flight.awaits_picture, false);
    if (flight.stamp.volume.volume_id < shown_volume_id_) {
      counters_.pictures_outdated.add();
      if (first) counters_.volumes_skipped.add();
      continue;
    }
    shown_ = index;
    shown_volume_id_ = flight.stamp.volume.volume_id;
    flight.stamp.picture_id = ++pictures_;
    flight.stamp.stage_ms = flight.slot.view().stage_ms(gpu_);
    flight.stamp.finished_time_ns = now_ns();
    counters_.pictures_finished.add();
    picture.stamp = flight.stamp;
    picture.width = config_.size.width;
    picture.height = config_.size.height;
    const auto rgba = flight.slot.view().picture();
    picture.rgba.assign(rgba.begin(), rgba.end());
    const auto depth_mm = flight.slot.view().depth_mm();
    picture.depth_mm.assign(depth_mm.begin(), depth_mm.end());
    if (first) counters_.volumes_rendered.add();
    return true;
  }
  return false;
}

bool Renderer::settled(const Flight& flight) const {
  return flight.slot.outstanding(gpu_) == 0 && !private_.reads(flight.slot);
}

Result<void> Renderer::want(const PrivateViews& views) {
  return private_.want(views);
}

Result<void> Renderer::advance_private() {
  Flight& shown = *flights_[shown_];
  if (busy() || !shown.slot.loaded() || shown.cast == 0 || view_changed(shown)) return {};
  return private_.advance({.slot = shown.slot,
                           .last = flights_[1 - shown_]->slot,
                           .cast_scene = shown.cast_scene.scene,
                           .cast = shown.cast,
                           .past = past_of(shown)});
}

bool Renderer::main_busy() const {
  return std::ranges::any_of(flights_, [this](const auto& flight) {
    return flight->phase != Phase::kIdle || flight->slot.outstanding(gpu_) > 0;
  });
}

Result<void> Renderer::wait(std::int64_t timeout_ns) {
  // One semaphore, the one that will be signalled first: Mesa waits for any of two in a busy loop, which
  // costs lavapipe half of two cores. On two queues the other may be done before; timeout_ns bounds what that
  // costs.
  const Flight* first = nullptr;
  for (const auto& flight : flights_) {
    if (flight->slot.outstanding(gpu_) == 0) continue;
    if (first == nullptr || flight->slot.view().submitted_ns() < first->slot.view().submitted_ns())
      first = flight.get();
  }
  const VolumeView* view = first != nullptr ? &first->slot.view() : nullptr;
  const VolumeView* beside = private_.under_way();
  if (view == nullptr || (beside != nullptr && beside->submitted_ns() < view->submitted_ns())) view = beside;
  if (view == nullptr) return {};
  const VkSemaphore timeline = view->timeline();
  const std::uint64_t value = view->submissions();
  const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                 .semaphoreCount = 1,
                                 .pSemaphores = &timeline,
                                 .pValues = &value};
  const VkResult result = vkWaitSemaphores(gpu_.device(), &info, static_cast<std::uint64_t>(timeout_ns));
  if (result != VK_SUCCESS && result != VK_TIMEOUT) return vulkan_error("vkWaitSemaphores", result);
  return {};
}

Result<DepthMaps> Renderer::read_depth() {
  return flights_[shown_]->slot.view().read_depth(gpu_);
}

}  // namespace fanlight
