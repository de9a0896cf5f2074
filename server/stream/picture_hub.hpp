// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_set>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "server/codec/encoder_pool.hpp"
#include "server/codec/picture_coder.hpp"
#include "server/codec/surface_coder.hpp"
#include "server/state/server_counters.hpp"
#include "server/stream/picture_snapshot.hpp"
#include "server/stream/picture_subscriber.hpp"

namespace fanlight {

/// Offers each picture to every subscriber of its view. Subscribers of one view with equal settings share one
/// encoding, and a picture that no subscriber needs is not encoded. The encoding runs elsewhere; while an
/// encoding is busy, newer pictures replace those that wait for it. Server thread only.
class PictureHub {
 public:
  using CoderFactory = std::function<Result<std::unique_ptr<PictureCoder>>(const StreamSettings&)>;
  /// A picture of the main view as a file.
  struct PictureFile {
    SharedMessage bytes;
    PictureStamp stamp;
  };
  using FileReady = std::function<void(const Result<PictureFile>&)>;

  /// Most encodings (view and settings) at a time.
  static constexpr std::size_t kMostEncodings = 16;
  /// Of these, most in the heavy lane whose subscribers are all viewers.
  static constexpr std::size_t kMostHeavyOfViewers = 4;
  /// Most requests for a picture as a file that wait at a time.
  static constexpr std::size_t kMostFileRequests = 64;
  /// Most kinds of files that are made at a time.
  static constexpr std::size_t kMostFileKinds = 8;

  struct Config {
    CoderFactory make_coder = [](const StreamSettings& settings) { return fanlight::make_coder(settings); };
    Clock clock = now_ns;
    /// The default encodes at once, on the server thread.
    Executor executor = [](EncoderLane, const auto& work, const auto& done) {
      work();
      done();
    };
    std::size_t threads = 1;  ///< of each lane: the number of encodings at a time
    /// Of pictures in streams without a size, of views and of depth maps; absent: as rendered.
    std::optional<PictureSize> usual_size{};
    /// Called with the largest sizes that subscribers ask for, where they have changed.
    std::function<void(const WantedSizes&)> wanted_sizes{};
  };

  /// `counters` must outlive the hub. Tests replace what is in `config`.
  explicit PictureHub(ServerCounters& counters) : PictureHub(counters, Config()) {}
  PictureHub(ServerCounters& counters, Config config);
  ~PictureHub();

  /// Offers the picture to all subscribers of its view whose rate has a picture due, as soon as it is
  /// encoded. The picture must stay unchanged until the next call for the same view. A subscriber receives
  /// its private view from the first picture of that view on. Calls encoding_failed() of each subscriber
  /// whose picture cannot be encoded.
  void show(const Picture& picture);

  /// The private view of the subscriber has ended: it receives the main view again.
  void forget_view(PictureSubscriber& subscriber);

  /// The newest picture of the main view is too old to be offered to anybody.
  void forget_main_view();

  /// Subscribes, and offers the newest picture of the view if there is one.
  void add(PictureSubscriber& subscriber);

  /// Unsubscribes, and forgets the private view of the subscriber.
  void remove(PictureSubscriber& subscriber);

  /// Whether a subscriber may use these settings. Error, kUnavailable: there are kMostEncodings others, or,
  /// for a viewer, kMostHeavyOfViewers others of the heavy lane.
  Result<void> has_room(const PictureSubscriber& subscriber, const StreamSettings& settings) {
    return has_room(subscriber.view_id(), subscriber.privileged(), settings);
  }
  /// The same for one that is not there yet, of this view.
  Result<void> has_room(std::uint64_t view_id, bool privileged, const StreamSettings& settings);

  /// The subscriber has other settings now, or has missed a picture that the next one depends on. Offers it
  /// the newest picture. If other subscribers share its H.264 stream, requests a key picture of that stream
  /// instead: at once if the picture does not change and the last key picture is old enough, else with the
  /// next picture.
  void resync(PictureSubscriber& subscriber);

  std::size_t subscriber_count() const { return subscribers_.size(); }

  /// The newest picture of a view; null before the first.
  const Picture* newest_picture(std::uint64_t view_id = 0) const {
    const auto shown = shown_.find(view_id);
    return shown == shown_.end() ? nullptr : shown->second.picture;
  }

  /// Encodes the newest picture of the main view as a file, once for all who ask for the same meanwhile: JPEG
  /// or PNG, in its own size where the settings have none. Precondition: there is one. Error, kUnavailable:
  /// kMostFileRequests wait already, or kMostFileKinds are made.
  void file(const StreamSettings& settings, FileReady ready);

  /// Runs `work` on the newest picture of the main view, on a thread that encodes, and then `done` on this
  /// one. Precondition: there is one. Error, kUnavailable: kMostWorks of them run already.
  Result<void> work_on_newest(std::function<void(const Picture&)> work, std::function<void()> done);
  static constexpr std::size_t kMostWorks = 4;

 private:
  /// The view, and those settings that the encoding depends on.
  using EncodingKey = std::pair<std::uint64_t, StreamSettings>;
  /// What encodes; used by one job at a time, on its thread.
  struct Machine {
    std::unique_ptr<PictureCoder> coder;
    PictureScaler scaler;
    PictureMarker marker;
    SurfaceCoder surface_coder;
    v1::Surface surface;  // of the last picture that has one

    /// Sets `surface`.
    Result<void> pack_surface(const Picture& picture);
  };
  struct Encoding {
    std::shared_ptr<Machine> machine = std::make_shared<Machine>();
    PictureOffer offer;           // of the newest picture; without a message until it is encoded
    std::set<std::uint64_t> due;  // subscribers that wait for the newest picture
    bool queued = false;          // waits for a thread of its lane
    bool running = false;
    bool key_requested = false;     // for the next picture
    std::int64_t key_coded_ns = 0;  // when the last key picture was encoded
  };
  struct Shown {
    const Picture* picture = nullptr;
    std::int64_t since_ns = 0;
    std::shared_ptr<PictureSnapshot> snapshot;  // of the picture, once a job needs it
  };
  struct Lane {
    std::deque<EncodingKey> queue;
    std::size_t running = 0;
  };
  struct Job;
  struct FileJob;

  static EncodingKey key_of(const PictureSubscriber& subscriber);
  void want(const EncodingKey& encoding_key, const PictureSubscriber& subscriber);
  void enqueue(const EncodingKey& encoding_key, Encoding& encoding);
  void start_jobs();
  void start(EncoderLane lane, const EncodingKey& encoding_key, Encoding& encoding);
  void finished(Job& job);
  void deliver(const EncodingKey& encoding_key, const std::set<std::uint64_t>& due, const Job& job);
  void start_file(const StreamSettings& settings, const std::shared_ptr<FileJob>& job);
  void forget_files();
  std::shared_ptr<PictureSnapshot> snapshot_of(Shown& shown);
  void resync_shared(const EncodingKey& encoding_key, Encoding& encoding, const Shown& shown);
  void drop_unused_encodings();
  void report_wanted_sizes();

  ServerCounters& counters_;
  Config config_;
  WantedSizes wanted_sizes_;  // as reported last
  std::size_t works_ = 0;     // of work_on_newest()
  std::unordered_set<PictureSubscriber*> subscribers_;
  std::map<EncodingKey, Encoding> encodings_;
  std::map<std::uint64_t, Shown> shown_;  // by view
  std::array<Lane, kEncoderLanes> lanes_;
  std::vector<std::shared_ptr<PictureSnapshot>> snapshots_;   // unused ones are used again
  std::map<StreamSettings, std::shared_ptr<FileJob>> files_;  // shared with the jobs that run
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
