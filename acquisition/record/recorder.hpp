// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "acquisition/record/finish_recording.hpp"
#include "acquisition/record/recording_finisher.hpp"
#include "acquisition/record/recording_names.hpp"
#include "acquisition/record/segment.hpp"
#include "acquisition/record/segment_sync.hpp"
#include "acquisition/source/frame_source.hpp"
#include "proto/base/clock.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/frame_tap.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/recording_link.hpp"

namespace fanlight {

/// Writes the frames of a source to PLUS sequences on a thread of its own, so that a slow disk costs the
/// stream nothing. The acquisition thread fills the tap; if the disk does not take the frames for longer than
/// the tap's queue lasts, or has no room, frames are missing in the recording, counted, and a gap in its
/// sequence numbers. Of a recording that is no ring, each frame that came is kept, counted as missed, or
/// still in the tap.
///
/// While it records, frames stand in segments (segment.hpp), which reach the kernel every quarter of a
/// second, and the disk every five (SegmentSync). The final file is written on a second thread. A change of
/// the frames' geometry, and a file longer than kMostFramesAFile, begin a further file: x.igs.mha,
/// x-2.igs.mha, ... A ring restarts instead.
class Recorder {
 public:
  static constexpr std::uint64_t kMostFramesAFile = 200'000;
  static constexpr std::int64_t kFlushNs = 250'000'000;
  static constexpr std::int64_t kRoomCheckNs = 1'000'000'000;

  struct Config {
    std::filesystem::path folder{};    ///< recordings in it that were cut off are finished first; empty: none
    PixelForm form = PixelForm::kRaw;  ///< of those
    /// Nothing is recorded while less than this is free on the disk. Final files may use it.
    std::uint64_t reserve_bytes = 0;
    /// Nothing is recorded while the files in `folder` are larger together; 0: no limit.
    std::uint64_t quota_bytes = 0;
  };
  /// `status_bell`: of the thread that reads the status; must outlive the recorder.
  Recorder(const SourceDescription& source, Doorbell& status_bell);
  Recorder(const SourceDescription& source, Doorbell& status_bell, Config config);
  /// As end(kLeave).
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  FrameTap& tap() { return tap_; }

  /// For one thread. The status comes with each change, and several times a second while it records.
  RecordingLink link() {
    return {.orders = orders_, .recorder_bell = bell_, .status = status_, .pictures = pictures_};
  }

  enum class Finish : std::uint8_t {
    kWait,  ///< writes the final files, however long it takes
    /// Leaves the segments of what is not finished at once; fanlight recover finishes them. Removes a ring.
    kLeave,
  };
  /// Ends the recording under way, and the threads. The status stays readable. With kLeave it returns within
  /// kMostEndNs, but for a disk that does not answer.
  void end(Finish finish);
  static constexpr std::int64_t kMostEndNs = 300'000'000;

 private:
  void run(const std::stop_token& stop);
  void work();
  void take_orders();
  void take(const RecordingOrder& order);
  void begin(const RecordingOrder& order);
  void close_recording(const std::filesystem::path& end_path, bool drop = false);
  void finish_left_overs();
  void finish_file(const std::filesystem::path& end_path);
  bool is_ring() const { return order_ && order_->ring_s > 0; }
  /// Writes up to this many frames of the queue.
  void drain(std::uint32_t most_frames);
  /// Whether the frame is in the open segment now.
  bool write(const QueuedFrame& frame);
  bool open_segment(const QueuedFrame& frame);
  void next_file();
  void next_segment();
  void drop_old_segments();
  void reached_limit();
  void take_pictures();
  void flush_if_due();
  void stop_for(const Error& error);
  /// Why there is no room for `more_bytes` on the disk.
  std::optional<Error> lack_of_room(std::uint64_t more_bytes);
  std::uint64_t used_bytes();
  void remove_oldest_segment();
  void try_again_if_due();
  bool waits() const { return order_ || finisher_.busy() || !postponed_.empty(); }
  void poll_finisher();
  void tell(const RecordingFinisher::Outcome& outcome);
  bool status_due();
  void publish_status();

  RecordingFacts facts_;
  Config config_;
  Doorbell bell_;
  FrameTap tap_;
  RecordingOrders orders_;
  Mailbox<RecordingStatus> status_;
  LineQueue pictures_;
  RecordingFinisher finisher_{bell_};
  SegmentSync sync_;

  // The recorder's thread only.
  std::optional<RecordingOrder> order_;  // of the recording under way
  std::uint64_t order_done_ = 0;
  std::uint32_t file_number_ = 0;  // of the recording, from 1
  std::uint32_t segment_number_ = 0;
  std::filesystem::path file_;           // the present one
  std::vector<SegmentPaths> segments_;   // of the present file, the open one last
  std::vector<std::int64_t> begins_ns_;  // capture times of their first frames
  std::optional<SegmentWriter> segment_;
  FanGeometry geometry_;        // of the open segment
  std::uint32_t revision_ = 0;  // of that geometry
  std::string scene_line_;      // the newest; each segment begins with it
  std::uint64_t frames_in_file_ = 0;
  std::uint64_t file_first_sequence_ = 0;  // smallest of these frames
  std::uint64_t file_last_sequence_ = 0;   // and greatest
  std::uint64_t frames_ = 0;               // of the recording
  std::uint64_t bytes_ = 0;
  std::optional<std::int64_t> first_time_ns_;
  std::int64_t last_time_ns_ = 0;
  std::uint64_t missed_before_ = 0;
  std::uint64_t not_written_ = 0;                  // frames of the recording that the disk had no room for
  RecordingStatus finished_;                       // the fields of recordings that are finished
  std::vector<RecordingFinisher::Job> postponed_;  // their final form could not be written
  std::int64_t next_try_ns_ = 0;                   // of those
  std::shared_ptr<RecordingLock> lock_;            // of the present file
  std::uint64_t lost_ = 0;                         // recordings that cannot be finished
  bool over_ = false;
  std::string trouble_;
  std::int64_t flushed_ns_ = 0;
  // Of the files in the folder at the last look, and of this recording then.
  std::uint64_t used_bytes_ = 0;
  std::uint64_t used_bytes_at_ = 0;
  std::int64_t used_looked_ns_ = 0;
  std::int64_t room_checked_ns_ = 0;  // when nothing is written
  // What the last status reported, and when.
  std::tuple<std::uint64_t, bool, std::string, bool, std::uint64_t, std::size_t, std::filesystem::path>
      published_;
  std::int64_t published_ns_ = 0;
  std::atomic<bool> waits_for_finish_{false};
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace fanlight
