// SPDX-License-Identifier: Apache-2.0
#include "server/stream/picture_hub.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <vector>

#include "proto/fanlight.pb.h"
#include "server/codec/reduced_picture.hpp"
#include "server/stream/picture_message.hpp"
#include "server/stream/server_messages.hpp"
#include "server/stream/wanted_sizes.hpp"

namespace fanlight {

namespace {

/// The settings without the rate, unless the coder depends on the pictures before: then the rate matters.
StreamSettings coding_settings(StreamSettings settings) {
  if (!settings.remembers()) settings.rate_hz = 0;
  // All displays get the same surfaces, and what is beside them in their size.
  if (settings.codec == StreamSettings::Codec::kSurface) settings.most_width = settings.most_height = 0;
  return settings;
}

void put_pixels(v1::Picture& message, StreamSettings::Codec codec, std::span<const std::uint8_t> bytes) {
  switch (codec) {
    case StreamSettings::Codec::kJpeg:
    case StreamSettings::Codec::kSurface:
      return message.set_jpeg(bytes.data(), bytes.size());
    case StreamSettings::Codec::kPng:
      return message.set_png(bytes.data(), bytes.size());
    case StreamSettings::Codec::kH264:
      return message.set_h264(bytes.data(), bytes.size());
  }
}

/// Whether a display with these settings is sent the surface of the picture: not where it could not make the
/// picture from it.
bool has_surface(const Picture& picture, const StreamSettings& settings) {
  const SurfacePart& part = picture.stamp.view.part;
  return settings.codec == StreamSettings::Codec::kSurface && part.width > 0 && !part.seen_through;
}

/// Describes a picture and its encoded pixels; without pixels where a display makes them from the surface.
v1::ServerMessage picture_message(PictureSnapshot& snapshot, const StreamSettings& settings,
                                  const Pixels& pixels, const CodedPicture& coded, PictureSize usual) {
  v1::ServerMessage message;
  v1::Picture& body = *message.mutable_picture();
  const Picture& picture = snapshot.picture();
  describe(body, picture);
  // Displays that get no surface know one size alone.
  if (!has_surface(picture, settings) && picture.height != usual.height)
    describe(*body.mutable_view(),
             scaled(picture.stamp.view, static_cast<double>(usual.height) / picture.height));
  body.set_width(pixels.width);
  body.set_height(pixels.height);
  body.set_key_picture(coded.key);
  if (!coded.bytes.empty()) put_pixels(body, settings.codec, coded.bytes);
  if (settings.with_depth) {
    body.set_depth(snapshot.depth(usual));
    body.set_depth_unit_mm(kDepthUnitMm);
  }
  return message;
}

/// A surface without its maps.
v1::Surface outline_of(const v1::Surface& surface) {
  v1::Surface outline;
  outline.set_surface_id(surface.surface_id());
  outline.set_left(surface.left());
  outline.set_top(surface.top());
  outline.set_width(surface.width());
  outline.set_height(surface.height());
  outline.set_as_depth(surface.as_depth());
  return outline;
}

/// Whether the surface is all that a picture shows.
bool is_surface_only(const Picture& picture) {
  const SurfacePart& part = picture.stamp.view.part;
  return part.width == picture.width && part.height == picture.height;
}

/// Runs an encoding on a thread of the pool. Where memory runs out, its result is an error, and the server
/// continues.
template <typename Made, typename Run>
void run_within_memory(Result<Made>& result, Run run) {
  try {
    run();
  } catch (const std::bad_alloc&) {
    result = Error{ErrorCode::kUnavailable, "there is no memory to encode the picture"};
  }
}

EncoderLane lane_of(const StreamSettings& settings) {
  const bool heavy = settings.with_depth || settings.codec == StreamSettings::Codec::kPng;
  return heavy ? EncoderLane::kHeavy : EncoderLane::kQuick;
}

}  // namespace

/// One picture in one encoding, from the server thread to a thread of the pool and back.
struct PictureHub::Job {
  EncodingKey encoding_key;
  std::shared_ptr<Machine> machine;
  std::shared_ptr<PictureSnapshot> snapshot;
  std::set<std::uint64_t> due = {};  // the subscribers that wait for it
  bool key = false;
  std::optional<PictureSize> usual_size = {};
  Result<PictureOffer> offer = Error{ErrorCode::kBroken, "the picture was not encoded"};

  void run(const CoderFactory& make_coder);
};

void PictureHub::Job::run(const CoderFactory& make_coder) {
  const auto& [view_id, settings] = encoding_key;
  if (machine->coder == nullptr) {
    auto coder = make_coder(settings);
    if (!coder) {
      offer = coder.error();
      return;
    }
    machine->coder = std::move(*coder);
  }
  const Picture& picture = snapshot->picture();
  const Pixels pixels = machine->scaler.fitted(pixels_of(picture), with_size(settings, usual_size));
  const bool with_surface = has_surface(picture, settings);
  Result<CodedPicture> coded = CodedPicture{};
  if (!with_surface || !is_surface_only(picture))
    coded = machine->coder->encode(machine->marker.marked(pixels, settings.mark), key);
  if (!coded) {
    offer = coded.error();
    return;
  }
  v1::ServerMessage message = picture_message(
      *snapshot, settings, pixels, *coded, usual_size.value_or(PictureSize{picture.width, picture.height}));
  PictureOffer made{.picture_id = picture.stamp.picture_id,
                    .scene_revision = picture.stamp.scene_revision,
                    .view_id = view_id,
                    .key = coded->key};
  if (with_surface) {
    if (auto packed = machine->pack_surface(picture); !packed) {
      offer = packed.error();
      return;
    }
    made.surface_id = picture.stamp.surface_id;
    *message.mutable_picture()->mutable_surface() = outline_of(machine->surface);
    made.without_surface = serialised(message);
    *message.mutable_picture()->mutable_surface() = machine->surface;
  }
  made.message = serialised(message);
  offer = std::move(made);
}

Result<void> PictureHub::Machine::pack_surface(const Picture& picture) {
  // Of a picture whose light alone has changed it is packed already.
  if (surface.surface_id() == picture.stamp.surface_id) return {};
  surface.Clear();
  return surface_coder.encode(picture, surface);
}

/// The newest picture as a file of one kind: who waits for it, and the last one made.
struct PictureHub::FileJob {
  std::vector<FileReady> waiting;
  bool running = false;
  std::unique_ptr<PictureCoder> coder;  // used by one job at a time
  PictureScaler scaler;
  PictureMarker marker;
  std::shared_ptr<PictureSnapshot> snapshot;  // of `made`, or of the job that runs
  Result<PictureFile> made = Error{ErrorCode::kBroken, "the picture was not encoded"};
  bool newest = false;  // `made` is of the newest picture

  void run(const CoderFactory& make_coder, const StreamSettings& settings);
};

void PictureHub::FileJob::run(const CoderFactory& make_coder, const StreamSettings& settings) {
  if (coder == nullptr) {
    auto new_coder = make_coder(settings);
    if (!new_coder) {
      made = new_coder.error();
      return;
    }
    coder = std::move(*new_coder);
  }
  const Picture& picture = snapshot->picture();
  const Pixels fitted =
      settings.has_size() ? scaler.fitted(pixels_of(picture), settings) : pixels_of(picture);
  const auto coded = coder->encode(marker.marked(fitted, settings.mark), true);
  if (!coded) {
    made = coded.error();
    return;
  }
  made = PictureFile{.bytes = std::make_shared<const std::string>(coded->bytes.begin(), coded->bytes.end()),
                     .stamp = picture.stamp};
}

PictureHub::PictureHub(ServerCounters& counters, Config config)
    : counters_(counters), config_(std::move(config)) {}

PictureHub::~PictureHub() = default;

PictureHub::EncodingKey PictureHub::key_of(const PictureSubscriber& subscriber) {
  return {subscriber.view_id(), coding_settings(subscriber.settings())};
}

void PictureHub::want(const EncodingKey& encoding_key, const PictureSubscriber& subscriber) {
  Encoding& encoding = encodings_[encoding_key];
  encoding.due.insert(subscriber.id());
  enqueue(encoding_key, encoding);
}

void PictureHub::enqueue(const EncodingKey& encoding_key, Encoding& encoding) {
  if (encoding.running || encoding.queued) return;
  lanes_[static_cast<std::size_t>(lane_of(encoding_key.second))].queue.push_back(encoding_key);
  encoding.queued = true;
}

void PictureHub::start_jobs() {
  for (const EncoderLane lane : {EncoderLane::kQuick, EncoderLane::kHeavy}) {
    Lane& state = lanes_[static_cast<std::size_t>(lane)];
    while (state.running < config_.threads && !state.queue.empty()) {
      const EncodingKey encoding_key = state.queue.front();
      state.queue.pop_front();
      const auto encoding = encodings_.find(encoding_key);
      if (encoding != encodings_.end() && std::exchange(encoding->second.queued, false))
        start(lane, encoding_key, encoding->second);
    }
  }
}

void PictureHub::start(EncoderLane lane, const EncodingKey& encoding_key, Encoding& encoding) {
  const auto shown = shown_.find(encoding_key.first);
  if (shown == shown_.end()) return encoding.due.clear();  // its private view has ended
  const auto job = std::make_shared<Job>(Job{.encoding_key = encoding_key,
                                             .machine = encoding.machine,
                                             .snapshot = snapshot_of(shown->second),
                                             .usual_size = config_.usual_size});
  std::size_t& running = lanes_[static_cast<std::size_t>(lane)].running;
  job->due.swap(encoding.due);
  job->key = std::exchange(encoding.key_requested, false);
  encoding.running = true;
  ++running;
  try {
    config_.executor(
        lane, [this, job] { run_within_memory(job->offer, [&] { job->run(config_.make_coder); }); },
        [this, job] { finished(*job); });
  } catch (const std::bad_alloc&) {
    // The next picture tries again.
    --running;
    encoding.running = false;
    encoding.due.merge(job->due);
    encoding.key_requested |= job->key;
    throw;
  }
}

std::shared_ptr<PictureSnapshot> PictureHub::snapshot_of(Shown& shown) {
  if (shown.snapshot != nullptr) return shown.snapshot;
  const auto free =
      std::ranges::find_if(snapshots_, [](const auto& snapshot) { return snapshot.use_count() == 1; });
  auto snapshot =
      free != snapshots_.end() ? *free : snapshots_.emplace_back(std::make_shared<PictureSnapshot>());
  snapshot->take(*shown.picture);
  shown.snapshot = snapshot;  // only whole
  return snapshot;
}

void PictureHub::finished(Job& job) {
  thread_owner_.check();
  --lanes_[static_cast<std::size_t>(lane_of(job.encoding_key.second))].running;
  const auto found = encodings_.find(job.encoding_key);
  // It may have been dropped meanwhile, and created again.
  if (found != encodings_.end() && found->second.machine == job.machine) {
    Encoding& encoding = found->second;
    encoding.running = false;
    if (job.offer) {
      counters_.pictures_encoded.add();
      if (job.offer->key) encoding.key_coded_ns = config_.clock();
      if (job.key && !job.offer->key) encoding.key_requested = true;
      const auto shown = shown_.find(job.encoding_key.first);
      if (shown != shown_.end() && shown->second.snapshot == job.snapshot) encoding.offer = *job.offer;
    }
    if (!encoding.due.empty()) enqueue(job.encoding_key, encoding);
    deliver(job.encoding_key, job.due, job);
  }
  start_jobs();
}

void PictureHub::deliver(const EncodingKey& encoding_key, const std::set<std::uint64_t>& due,
                         const Job& job) {
  std::vector<PictureSubscriber*> failed;
  for (PictureSubscriber* subscriber : subscribers_) {
    if (!due.contains(subscriber->id()) || key_of(*subscriber) != encoding_key) continue;
    if (job.offer) {
      subscriber->offer(*job.offer);
    } else {
      failed.push_back(subscriber);
    }
  }
  for (PictureSubscriber* subscriber : failed) subscriber->encoding_failed();
}

void PictureHub::show(const Picture& picture) {
  thread_owner_.check();
  const std::uint64_t view_id = picture.stamp.view_id;
  const std::int64_t shown_ns = picture.stamp.finished_time_ns;
  for (auto& [encoding_key, encoding] : encodings_) {
    if (encoding_key.first == view_id) encoding.offer.message = nullptr;
  }
  if (view_id == 0) forget_files();
  const std::int64_t last_shown_ns =
      std::exchange(shown_[view_id], {.picture = &picture, .since_ns = shown_ns, .snapshot = nullptr})
          .since_ns;
  for (PictureSubscriber* subscriber : subscribers_) {
    if (view_id != 0 && subscriber->id() == view_id) subscriber->set_view(view_id);
    if (subscriber->view_id() != view_id) continue;
    if (!picture_due(subscriber->settings().rate_hz, last_shown_ns, shown_ns)) continue;
    want(key_of(*subscriber), *subscriber);
  }
  start_jobs();
}

void PictureHub::add(PictureSubscriber& subscriber) {
  thread_owner_.check();
  subscribers_.insert(&subscriber);
  resync(subscriber);  // reports its size too
}

void PictureHub::remove(PictureSubscriber& subscriber) {
  subscribers_.erase(&subscriber);
  report_wanted_sizes();
  // Not the main view: its number is 0, which no subscriber has.
  shown_.erase(subscriber.id());
}

void PictureHub::forget_view(PictureSubscriber& subscriber) {
  thread_owner_.check();
  shown_.erase(subscriber.id());
  if (subscriber.view_id() == 0) return;
  subscriber.set_view(0);
  resync(subscriber);
}

void PictureHub::forget_main_view() {
  thread_owner_.check();
  for (auto& [encoding_key, encoding] : encodings_) {
    if (encoding_key.first == 0) encoding.offer.message = nullptr;
  }
  forget_files();
  shown_.erase(0);
}

Result<void> PictureHub::has_room(std::uint64_t view_id, bool privileged, const StreamSettings& settings) {
  drop_unused_encodings();
  if (encodings_.contains({view_id, coding_settings(settings)})) return {};
  if (encodings_.size() >= kMostEncodings) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("pictures are encoded in {} ways already, expected one of those or some patience",
                    kMostEncodings)};
  }
  if (privileged || lane_of(settings) == EncoderLane::kQuick) return {};
  const auto of_viewers = [this](const auto& entry) {
    return lane_of(entry.first.second) == EncoderLane::kHeavy &&
           std::ranges::none_of(subscribers_, [&](const PictureSubscriber* each) {
             return each->privileged() && key_of(*each) == entry.first;
           });
  };
  if (std::ranges::count_if(encodings_, of_viewers) < static_cast<std::ptrdiff_t>(kMostHeavyOfViewers))
    return {};
  return Error{
      ErrorCode::kUnavailable,
      fmt::format("viewers are sent PNG or depth maps in {} ways already, expected one of those, JPEG or "
                  "H.264 without depth, or the role of an operator",
                  kMostHeavyOfViewers)};
}

void PictureHub::report_wanted_sizes() {
  if (!config_.usual_size || !config_.wanted_sizes) return;
  WantedSizes wanted;
  for (const PictureSubscriber* subscriber : subscribers_)
    widen(wanted, subscriber->settings(), *config_.usual_size);
  if (wanted == wanted_sizes_) return;
  wanted_sizes_ = wanted;
  config_.wanted_sizes(wanted);
}

void PictureHub::resync(PictureSubscriber& subscriber) {
  thread_owner_.check();
  report_wanted_sizes();
  drop_unused_encodings();
  const auto shown = shown_.find(subscriber.view_id());
  if (shown == shown_.end()) return;
  const EncodingKey encoding_key = key_of(subscriber);
  const auto found = encodings_.find(encoding_key);
  if (found == encodings_.end()) {
    want(encoding_key, subscriber);
    return start_jobs();
  }
  Encoding& encoding = found->second;
  if (encoding_key.second.codec == StreamSettings::Codec::kH264)
    return resync_shared(encoding_key, encoding, shown->second);
  if (encoding.offer.message != nullptr) return subscriber.offer(encoding.offer);
  want(encoding_key, subscriber);
  start_jobs();
}

void PictureHub::resync_shared(const EncodingKey& encoding_key, Encoding& encoding, const Shown& shown) {
  constexpr std::int64_t kStillNs = 500'000'000;
  constexpr std::int64_t kBetweenKeysNs = 1'000'000'000;
  // A key picture is large and all subscribers of the stream receive it. If the next picture comes soon, that
  // one becomes the key picture.
  const std::int64_t now = config_.clock();
  encoding.key_requested = true;
  if (now - shown.since_ns < kStillNs || now - encoding.key_coded_ns < kBetweenKeysNs) return;
  for (PictureSubscriber* each : subscribers_) {
    if (key_of(*each) == encoding_key) want(encoding_key, *each);
  }
  start_jobs();
}

void PictureHub::drop_unused_encodings() {
  std::erase_if(encodings_, [this](const auto& entry) {
    return std::ranges::none_of(subscribers_, [&](const PictureSubscriber* subscriber) {
      return key_of(*subscriber) == entry.first;
    });
  });
}

void PictureHub::file(const StreamSettings& settings, FileReady ready) {
  thread_owner_.check();
  const auto found = files_.find(settings);
  if (found == files_.end() && files_.size() >= kMostFileKinds)
    std::erase_if(files_, [](const auto& entry) { return !entry.second->running; });
  if (found == files_.end() && files_.size() >= kMostFileKinds) {
    return ready(
        Error{ErrorCode::kUnavailable,
              fmt::format("pictures are asked for in {} sizes and qualities already, expected a later "
                          "request or one of those",
                          kMostFileKinds)});
  }
  const auto job = found != files_.end() ? found->second : std::make_shared<FileJob>();
  if (job->newest && !job->running) return ready(job->made);
  if (job->waiting.size() >= kMostFileRequests) {
    return ready(Error{
        ErrorCode::kUnavailable,
        fmt::format("{} requests wait for a picture already, expected a later request", kMostFileRequests)});
  }
  files_[settings] = job;
  job->waiting.push_back(std::move(ready));
  if (std::exchange(job->running, true)) return;
  try {
    start_file(settings, job);
  } catch (const std::bad_alloc&) {
    job->running = false;
    job->waiting.clear();  // their connections end
    throw;
  }
}

void PictureHub::start_file(const StreamSettings& settings, const std::shared_ptr<FileJob>& job) {
  job->snapshot = snapshot_of(shown_.at(0));
  config_.executor(
      lane_of(settings),
      [this, job, settings] {
        run_within_memory(job->made, [&] { job->run(config_.make_coder, settings); });
      },
      [this, job] {
        job->running = false;
        const auto shown = shown_.find(0);
        job->newest = shown != shown_.end() && shown->second.snapshot == job->snapshot;
        job->snapshot = nullptr;
        for (const FileReady& each : std::exchange(job->waiting, {})) each(job->made);
      });
}

/// There is a newer picture: the files of the last one are of no use.
void PictureHub::forget_files() {
  for (const auto& [settings, job] : files_) job->newest = false;
  std::erase_if(files_, [](const auto& entry) { return !entry.second->running; });
}

Result<void> PictureHub::work_on_newest(std::function<void(const Picture&)> work,
                                        std::function<void()> done) {
  thread_owner_.check();
  if (works_ >= kMostWorks) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} requests for a picture are carried out already, expected a later request",
                             kMostWorks)};
  }
  const auto snapshot = snapshot_of(shown_.at(0));
  ++works_;
  try {
    config_.executor(
        EncoderLane::kHeavy,
        [snapshot, work = std::move(work)] {
          try {
            work(snapshot->picture());
          } catch (const std::bad_alloc&) {
            // The result of the work stays the error that it was.
          }
        },
        [this, snapshot, done = std::move(done)] {
          --works_;
          done();
        });
  } catch (const std::bad_alloc&) {
    --works_;
    throw;
  }
  return {};
}

}  // namespace fanlight
