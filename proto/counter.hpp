#pragma once

#include <atomic>
#include <cstdint>

namespace fanlight {

/// A count that one thread raises and any thread reads. Relaxed: a reader sees each count whole, not all
/// counts of one instant.
class Counter {
 public:
  void add(std::uint64_t amount = 1) { value_.fetch_add(amount, std::memory_order_relaxed); }
  std::uint64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// Raised by the acquisition thread. frames_received = frames_assembled + frames_invalid +
/// frames_over_capacity + frames_in_short_volumes + frames_abandoned + those of the sweep being filled.
struct AcquisitionCounters {
  Counter frames_received;
  Counter frames_missing;           ///< gaps in the sequence: never received, so not part of the sum
  Counter frames_assembled;         ///< in volumes that were published
  Counter frames_invalid;           ///< marked invalid by the recording, or with an unusable angle
  Counter frames_over_capacity;     ///< of a sweep longer than it announced, or than a volume can hold
  Counter frames_in_short_volumes;  ///< of sweeps dropped because their angle did not move
  Counter volumes_short;            ///< the sweeps of the line above
  Counter frames_abandoned;         ///< of the sweep being filled when acquisition was stopped
};

/// Raised by the ring: volumes_published = volumes_taken + volumes_dropped + those still waiting.
struct RingCounters {
  Counter volumes_published;
  Counter volumes_taken;    ///< read by the render thread
  Counter volumes_dropped;  ///< replaced unread by a newer one (newest wins)
};

/// Raised by the render thread. pass2_runs = pictures_finished + pictures_outdated + those in flight;
/// pictures_finished = read + pictures_replaced + the one still unread.
struct RenderCounters {
  Counter pass1_runs;  ///< ray casts: a moved light never raises this
  Counter pass2_runs;  ///< filter, light and finish
  Counter
      volumes_unfiltered;  ///< cast without the speckle filter asked for: too large for this GPU's buffers
  Counter pictures_finished;
  Counter pictures_outdated;  ///< done after a picture of a newer volume, and so not shown
  Counter pictures_replaced;  ///< replaced unread in the picture mailbox by a newer one
};

}  // namespace fanlight
