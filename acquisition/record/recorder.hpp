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
#include "acquisition/record/frame_tap.hpp"
#include "acquisition/record/recording_finisher.hpp"
#include "acquisition/record/segment.hpp"
#include "acquisition/source/frame_source.hpp"
#include "proto/base/clock.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"

namespace fanlight {

/// What a recorder is asked for. Numbered from 1, so that a status can refer to it.
struct RecordingOrder {
  enum class Wish : std::uint8_t {
    kRecord,  ///< begins a recording; one that is under way is finished first
    kFinish,  ///< ends it; in a ring, keeps its last seconds
    kDrop,    ///< ends it and removes it
  };
  std::uint64_t number = 0;
  Wish wish = Wish::kFinish;
  // Of kRecord:
  std::filesystem::path path;  ///< ends with .mha or .mhd; nothing has this name yet
  PixelForm form = PixelForm::kRaw;
  double most_s = 0;             ///< ends after so many seconds; 0: no limit
  std::uint64_t most_bytes = 0;  ///< ends after so many bytes of pixels; 0: no limit
  double ring_s = 0;             ///< keeps only the last so many seconds; 0: all
};

/// State of a recorder, for people and programs.
struct RecordingStatus {
  enum class State : std::uint8_t {
    kIdle,
    kRecording,
    kNoRoom,     ///< the disk took no more; it begins again, in a further file, when there is room
    kFinishing,  ///< the last recording gets its final form
  };
  State state = State::kIdle;
  std::uint64_t order_done = 0;  ///< number of the newest order that was taken
  std::string file;              ///< of the recording under way, or being finished; empty: none
  std::uint64_t frames = 0;      ///< of it
  std::uint64_t bytes = 0;
  double duration_s = 0;
  std::uint64_t frames_missed = 0;  ///< frames that the recorder had no room for in its memory
  double finish_share = 0;          ///< 0 to 1, while the state is kFinishing
  std::string trouble;              ///< why nothing is written; empty: no trouble
  std::uint64_t finished = 0;       ///< recordings finished so far
  std::string last_file;            ///< the newest of them
  std::uint64_t last_frames = 0;
  std::uint64_t last_bytes = 0;
  double last_duration_s = 0;
  std::string last_trouble;  ///< why the newest could not be finished; its parts stay beside its name
};

/// Writes the frames of a source to PLUS sequences on a thread of its own, so that a slow disk costs the
/// stream nothing. The acquisition thread fills the tap; if the disk does not take the frames for longer than
/// the tap's queue lasts, frames are missing in the recording, counted, and a gap in its sequence numbers.
///
/// While it records, frames stand in segments (segment.hpp), which reach the kernel every quarter of a
/// second. The final file is written on a second thread. A change of the frames' geometry, and a file longer
/// than kMostFramesAFile, begin a further file: x.igs.mha, x-2.igs.mha, ...
class Recorder {
 public:
  static constexpr std::uint64_t kMostFramesAFile = 200'000;
  static constexpr std::int64_t kFlushNs = 250'000'000;
  static constexpr std::int64_t kRoomCheckNs = 1'000'000'000;

  /// `status_bell`: of the thread that reads status(); must outlive the recorder.
  Recorder(const SourceDescription& source, Doorbell& status_bell);
  /// As end(kLeave).
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  FrameTap& tap() { return tap_; }

  /// One thread. The newest order wins.
  Mailbox<RecordingOrder>& orders() { return orders_; }
  /// One thread. Changes, and several a second while it records.
  Mailbox<RecordingStatus>& status() { return status_; }

  enum class Finish : std::uint8_t {
    kWait,   ///< writes the final files, however long it takes
    kLeave,  ///< leaves the segments of what is not finished at once; fanlight recover finishes them
  };
  /// Ends the recording under way, and the threads. The status stays readable.
  void end(Finish finish);

 private:
  void run(const std::stop_token& stop);
  void take_orders();
  void begin(const RecordingOrder& order);
  void close_recording(bool keep);
  void drain();
  void write(const QueuedFrame& frame);
  bool open_segment(const QueuedFrame& frame);
  void next_file();
  void next_segment();
  void drop_old_segments();
  void reached_limit();
  void flush_if_due();
  void stop_for(const Error& error);
  void try_again_if_due();
  void poll_finisher();
  bool status_due();
  void publish_status();

  RecordingFacts facts_;
  Doorbell bell_;
  FrameTap tap_;
  Mailbox<RecordingOrder> orders_{bell_};
  Mailbox<RecordingStatus> status_;
  RecordingFinisher finisher_{bell_};

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
  std::uint64_t frames_in_file_ = 0;
  std::uint64_t frames_ = 0;  // of the recording
  std::uint64_t bytes_ = 0;
  std::optional<std::int64_t> first_time_ns_;
  std::int64_t last_time_ns_ = 0;
  std::uint64_t missed_before_ = 0;
  RecordingStatus finished_;  // the fields of recordings that are finished
  std::string trouble_;
  std::int64_t flushed_ns_ = 0;
  std::int64_t room_checked_ns_ = 0;
  // What the last status told of, and when.
  std::tuple<std::uint64_t, bool, std::string, bool, std::uint64_t, std::filesystem::path> published_;
  std::int64_t published_ns_ = 0;
  std::atomic<bool> waits_for_finish_{false};
  std::jthread thread_;  // last: it uses all of the above
};

/// x.igs.mha -> x-2.igs.mha; the first file of a recording has the name itself.
std::filesystem::path file_of_recording(const std::filesystem::path& path, std::uint32_t number);

}  // namespace fanlight
