// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>

#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/small_queue.hpp"

namespace fanlight {

/// How the pixels of a finished recording are stored.
enum class PixelForm : std::uint8_t { kRaw, kZlib };

/// What a recorder is asked for. Numbered from 1, so that a status can refer to it.
struct RecordingOrder {
  enum class Wish : std::uint8_t {
    kRecord,  ///< begins a recording; one that is under way is ended first
    kEnd,     ///< ends the one that is under way
  };
  std::uint64_t number = 0;
  Wish wish = Wish::kEnd;
  // Of the recording that is under way:
  bool drops = false;              ///< it is removed, not finished, where it is a ring
  std::filesystem::path end_path;  ///< the name that it gets; empty: its own
  // Of the one to begin, for kRecord:
  std::filesystem::path path;  ///< ends with .mha or .mhd; nothing has this name yet
  PixelForm form = PixelForm::kRaw;
  double most_s = 0;             ///< ends after this time; 0: no limit
  std::uint64_t most_bytes = 0;  ///< ends after this many bytes of pixels; 0: no limit
  double ring_s = 0;             ///< keeps only the last seconds; 0: all
};

inline constexpr std::uint64_t kNoSequence = std::numeric_limits<std::uint64_t>::max();

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
  bool ring = false;             ///< the recording under way keeps its last seconds only
  std::string file;              ///< of the recording under way, or being finished; empty: none
  std::uint64_t frames = 0;      ///< of it
  std::uint64_t bytes = 0;
  double duration_s = 0;
  /// Smallest FrameStamp::sequence in `file`; kNoSequence: it has no frame yet.
  std::uint64_t first_sequence = kNoSequence;
  std::uint64_t last_sequence = 0;  ///< and greatest
  std::uint64_t frames_missed =
      0;                          ///< frames that the recorder had no room for, in its memory or on the disk
  double finish_share = 0;        ///< 0 to 1, while the state is kFinishing
  std::string trouble;            ///< why nothing is written; empty: no trouble
  bool over = false;              ///< the recorder has failed, and takes no more orders
  std::uint64_t finished = 0;     ///< recordings that were ended so far, finished or not
  std::uint64_t unfinished = 0;   ///< of them, those whose final form could not be written yet
  std::string last_file;          ///< the newest of them
  bool last_was_cut_off = false;  ///< it was left over from a crash
  std::uint64_t last_frames = 0;
  std::uint64_t last_bytes = 0;
  double last_duration_s = 0;
  std::uint64_t last_file_first_sequence = 0;  ///< smallest and greatest FrameStamp::sequence in it
  std::uint64_t last_file_last_sequence = 0;
  std::string last_trouble;  ///< why the newest could not be finished; its parts stay next to its name
};

using RecordingOrders = SmallQueue<RecordingOrder, 16>;
using LineQueue = SmallQueue<std::string, 256>;

/// The server's ends of a recorder.
struct RecordingLink {
  RecordingOrders& orders;
  Doorbell& recorder_bell;  ///< to be rung after an order
  Mailbox<RecordingStatus>& status;
  /// What the displays saw, a line of JSON each, for the file FILE.pictures.jsonl next to the recording: a
  /// scene
  /// ({"scene_revision": ...}, kept for the next recording too), or a picture.
  LineQueue& pictures;

  /// False where too many orders wait.
  bool send(RecordingOrder order) const {
    const bool put = orders.put(std::move(order));
    recorder_bell.ring();
    return put;
  }
};

}  // namespace fanlight
