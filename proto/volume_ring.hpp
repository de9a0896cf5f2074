#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "proto/counter.hpp"
#include "proto/doorbell.hpp"
#include "proto/volume.hpp"

namespace fanlight {

/// What the ring does when volumes come faster than they are read.
enum class RingPolicy : std::uint8_t {
  kNewestWins,  ///< live: the reader gets the newest, older unread ones are dropped and counted
  kProcessAll,  ///< to a file: the reader gets each in turn, the writer waits for room
};

/// Volumes on their way from the acquisition thread (writer) to the render thread (reader). All memory is
/// allocated by the constructor; afterwards no call locks, allocates or waits.
///
/// Life of a slot: free -> writing -> published -> reading -> free; under newest-wins also
/// published -> free, where the writer needs the oldest unread one or the reader passes over it.
class VolumeRing {
 public:
  struct Config {
    FanGeometry geometry;
    std::uint32_t frame_capacity = 0;  ///< frames a volume can hold
    std::uint32_t slots = 4;           ///< 3 at least: one written, one waiting, one read
    RingPolicy policy = RingPolicy::kNewestWins;
    /// Of other geometries that the source may change to; 0: none larger.
    std::uint64_t largest_frame_bytes = 0;
  };
  /// Both must outlive the ring; publishing rings the reader's, releasing the writer's.
  struct Dependencies {
    Doorbell& reader_bell;
    Doorbell& writer_bell;
  };

  VolumeRing(const Config& config, const Dependencies& dependencies);

  /// Writer: an empty volume to fill, the same one until publish() or abandon(); nullptr where the policy
  /// is process-all and every slot is taken: wait for the writer's bell.
  Volume* begin();

  /// Writer: gives the volume of begin() its id and hands it to the reader.
  void publish();

  /// Writer: gives the volume of begin() up.
  void abandon();

  /// A volume that the reader holds; its slot returns to the ring when this is destroyed. Must not outlive
  /// the ring.
  class Lease {
   public:
    Lease() = default;
    Lease(VolumeRing& ring, std::uint32_t slot) : ring_(&ring), slot_(slot) {}
    Lease(Lease&& other) noexcept : ring_(std::exchange(other.ring_, nullptr)), slot_(other.slot_) {}
    Lease& operator=(Lease&& other) noexcept {
      std::swap(ring_, other.ring_);
      std::swap(slot_, other.slot_);
      return *this;
    }
    ~Lease() {
      if (ring_ != nullptr) ring_->release(slot_);
    }
    explicit operator bool() const { return ring_ != nullptr; }
    const Volume& operator*() const { return *ring_->slots_[slot_].volume; }
    const Volume* operator->() const { return &**this; }

   private:
    VolumeRing* ring_ = nullptr;
    std::uint32_t slot_ = 0;
  };

  /// Reader: the next volume by the ring's policy (the newest; or the oldest unread), or an empty lease.
  /// The reader holds one lease at a time.
  Lease take();

  /// Whether take() would find a volume. Reader thread.
  bool has_published() const;

  const RingCounters& counters() const { return counters_; }
  std::uint32_t frame_capacity() const { return slots_.front().volume->frame_capacity(); }
  std::uint64_t capacity_bytes() const;

 private:
  // A slot's state and the id of the volume in it change as one word, so that neither side can mistake a
  // reused slot for the one it looked at.
  enum State : std::uint64_t { kFree, kWriting, kPublished, kReading };
  static constexpr std::uint64_t kStateBits = 2;
  static constexpr std::uint64_t word(State state, std::uint64_t id) { return id << kStateBits | state; }
  static constexpr State state_of(std::uint64_t word) {
    return static_cast<State>(word & ((1U << kStateBits) - 1));
  }

  struct Slot {
    std::unique_ptr<Volume> volume;
    std::atomic<std::uint64_t> state{kFree};
  };

  std::uint32_t oldest_published(std::uint64_t& seen) const;
  void release(std::uint32_t slot);

  static constexpr std::uint32_t kNone = ~0U;

  RingPolicy policy_;
  Dependencies dependencies_;
  std::vector<Slot> slots_;
  RingCounters counters_;
  std::uint32_t writing_ = kNone;  // writer's
  std::uint64_t last_id_ = 0;      // writer's
};

}  // namespace fanlight
