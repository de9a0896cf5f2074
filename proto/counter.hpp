#pragma once

#include <atomic>
#include <cstdint>

namespace fanlight {

/// A count that one thread raises and any thread reads.
class Counter {
 public:
  void add(std::uint64_t amount = 1) { value_.fetch_add(amount, std::memory_order_release); }
  std::uint64_t value() const { return value_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// A value that one thread sets and any thread reads.
template <typename T>
class Gauge {
 public:
  void set(T value) { value_.store(value, std::memory_order_release); }
  T value() const { return value_.load(std::memory_order_acquire); }

 private:
  std::atomic<T> value_{};
};

/// Makes several counters change as one for who reads them, so that their sum holds at any moment. One thread
/// writes, any thread reads; the writer never waits. (A sequence lock; the counters' own release and acquire
/// order them against it.)
class Ledger {
 public:
  /// Writer: while it lives, readers wait. Entries may nest.
  class Entry {
   public:
    explicit Entry(Ledger& ledger) : ledger_(ledger) {
      if (ledger_.depth_++ == 0) ledger_.turn_.fetch_add(1, std::memory_order_release);
    }
    ~Entry() {
      if (--ledger_.depth_ == 0) ledger_.turn_.fetch_add(1, std::memory_order_release);
    }
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

   private:
    Ledger& ledger_;
  };

  /// Any thread: calls `read` until no entry was made meanwhile; `read` must only copy counters.
  template <typename Read>
  void read(Read&& read) const {
    for (;;) {
      const std::uint64_t before = turn_.load(std::memory_order_acquire);
      read();
      if (before % 2 == 0 && turn_.load(std::memory_order_acquire) == before) return;
    }
  }

 private:
  std::atomic<std::uint64_t> turn_{0};  // odd while an entry is being made
  int depth_ = 0;                       // writer's
};

/// Raised by the acquisition thread, in entries of `ledger`. At any moment
///   frames_received = frames_assembled + frames_invalid + frames_damaged + frames_cut + frames_misfit +
///                     frames_repeated + frames_late + frames_over_capacity + frames_in_short_volumes +
///                     frames_in_incomplete_volumes + frames_abandoned + frames_pending.
struct AcquisitionCounters {
  Ledger ledger;
  Counter frames_received;
  Counter frames_assembled;              ///< in volumes that were published
  Counter frames_invalid;                ///< marked invalid by their maker, or with an unusable angle
  Counter frames_damaged;                ///< whose checksum is wrong
  Counter frames_cut;                    ///< that ended before their last pixel
  Counter frames_misfit;                 ///< of another size, pixel format or geometry than the source's
  Counter frames_repeated;               ///< whose sequence number had come before
  Counter frames_late;                   ///< that came after their sweep was closed
  Counter frames_over_capacity;          ///< of a sweep longer than it announced, or than a volume can hold
  Counter frames_in_short_volumes;       ///< of sweeps dropped because their angle did not move
  Counter frames_in_incomplete_volumes;  ///< of sweeps dropped because too many of their frames are missing
  Counter frames_abandoned;              ///< of the sweep under way at a stop, a lost probe, another geometry
  Gauge<std::uint64_t> frames_pending;   ///< of the sweep being filled

  // Not part of the sum.
  Counter frames_missing;      ///< gaps in the sequence: never received, or not before their sweep had ended
  Counter frames_reordered;    ///< that came after a later one, and were used all the same
  Counter sequence_restarts;   ///< the sequence began anew without a word
  Counter volumes_short;       ///< the sweeps of frames_in_short_volumes
  Counter volumes_incomplete;  ///< the sweeps of frames_in_incomplete_volumes
  Counter volumes_interpolated;  ///< published with gaps that neighbouring frames fill
  Counter geometry_changes;      ///< of the source, in mid-stream

  /// Frames that came and are in no volume: of no use, or of sweeps that could not be used.
  std::uint64_t frames_unused() const {
    return frames_invalid.value() + frames_damaged.value() + frames_cut.value() + frames_misfit.value() +
           frames_repeated.value() + frames_late.value() + frames_over_capacity.value() +
           frames_in_short_volumes.value() + frames_in_incomplete_volumes.value() + frames_abandoned.value();
  }
  /// Those, and the ones that never came.
  std::uint64_t frames_lost() const { return frames_unused() + frames_missing.value(); }

  /// Whether the sum above holds now; any thread.
  bool sum_holds() const {
    bool holds = false;
    ledger.read([&] {
      holds = frames_received.value() == frames_assembled.value() + frames_unused() + frames_pending.value();
    });
    return holds;
  }

  // How far forward and backward sweeps disagree; see SweepMismatch.
  Counter mismatch_estimates;       ///< pairs of sweeps that were compared
  Counter mismatch_refusals;        ///< pairs with too little in them to compare
  Gauge<double> mismatch_deg;       ///< estimated, and taken out of the angles
  Gauge<double> mismatch_left_deg;  ///< what the newest pairs still disagree by
  Gauge<double> mismatch_left_mm;   ///< the same at the middle of the depth
};

/// Raised by the acquisition thread where the source is a USB probe.
struct ProbeCounters {
  Counter bytes_received;
  Counter transfers_completed;
  Counter transfers_short;       ///< ended in the midst of a frame
  Counter transfers_stalled;     ///< the pipe was halted, and cleared again
  Counter transfers_timed_out;   ///< no byte came for 1.5 s; the stream was started again
  Counter transfers_overflowed;  ///< the probe sent more than was asked for
  Counter transfers_failed;      ///< any other error on the bus
  Counter transfers_refused;     ///< the system did not take a read
  Counter bytes_skipped;         ///< noise: bytes between frames that are no frame
  Counter streams_restarted;
  Counter requests_failed;  ///< control requests that the probe did not answer, or stalled
  Counter probes_found;
  Counter probes_lost;
  Counter settings_taken;
  Counter settings_refused;
};

/// Raised by the ring: volumes_published = volumes_taken + volumes_dropped + those still waiting.
struct RingCounters {
  Counter volumes_published;
  Counter volumes_taken;    ///< read by the render thread
  Counter volumes_dropped;  ///< replaced unread by a newer one (newest wins)
};

/// Raised by the feed, on the acquisition thread: every frame that was committed while there was a feed is
/// one of the two.
struct FeedCounters {
  Counter frames_fed;      ///< handed to the render thread ahead of their volume
  Counter frames_not_fed;  ///< that found the feed full, or are too large for it: they come with their volume
};

/// Raised by the render thread. Of the volumes that it took from its ring
///   RingCounters::volumes_taken = volumes_rendered + volumes_skipped + volumes_refused + those in flight,
/// at most two, none at rest and none when the renderer is gone. Who reads volumes_taken last never finds it
/// smaller than the others' sum. pass2_runs = pictures_finished + pictures_outdated + those in flight;
/// pictures_finished = read + pictures_replaced + the one still unread.
struct RenderCounters {
  Counter pass1_runs;        ///< ray casts: a moved light never raises this
  Counter pass2_runs;        ///< filter, light and finish
  Counter volumes_rendered;  ///< that had a picture
  Counter volumes_skipped;   ///< given up at the end, or outdated, before they had one
  Counter volumes_refused;   ///< of a geometry that this GPU has no room for
  Counter
      volumes_unfiltered;  ///< cast without the speckle filter asked for: too large for this GPU's buffers
  Counter pictures_finished;
  Counter pictures_outdated;  ///< done after a picture of a newer volume, and so not shown
  Counter pictures_replaced;  ///< replaced unread in the picture mailbox by a newer one

  // Of private views; none of the above counts them.
  Counter private_casts;
  Counter private_casts_given_up;  ///< since the main view took their frames, or nobody wanted them any more
  Counter private_pictures;
  Counter private_views_refused;  ///< that this GPU had no memory for
  /// Of the last second or two, the share of time in which the main view had work under way.
  Gauge<double> main_busy_share;
};

}  // namespace fanlight
