// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "proto/exchange/doorbell.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Policy when volumes are produced faster than they are read.
enum class RingPolicy : std::uint8_t {
  kNewestWins,  ///< live: the reader gets the newest volume; older unread ones are dropped and counted
  kProcessAll,  ///< offline: the reader gets every volume in order; the writer waits for a free slot
};

/// Volumes on their way from the acquisition thread (writer) to the render thread (reader). The constructor
/// allocates all memory; afterwards no call locks, allocates or blocks.
///
/// Life of a slot: free -> writing -> published -> reading -> free. Under kNewestWins also published -> free,
/// when the writer needs the slot of the oldest unread volume, or the reader skips it. A free slot still
/// holds its volume until the writer takes it, the oldest first; keep() saves such volumes: free -> kept ->
/// free.
class VolumeRing {
 public:
  struct Config {
    FanGeometry geometry;
    std::uint32_t frame_capacity = 0;  ///< largest number of frames in a volume
    std::uint32_t slots = 4;           ///< at least 3: one written, one waiting, one read
    std::uint32_t kept = 0;            ///< further slots, for keep(); none of them waits to be read
    RingPolicy policy = RingPolicy::kNewestWins;
    /// Frame size of the largest geometry that the source may change to; 0: no larger one.
    std::uint64_t largest_frame_bytes = 0;
  };
  /// Both must outlive the ring. Publishing rings the reader's bell, releasing a slot the writer's.
  struct Dependencies {
    Doorbell& reader_bell;
    Doorbell& writer_bell;
  };

  VolumeRing(const Config& config, const Dependencies& dependencies);

  /// Writer: an empty volume to fill, the same one until publish() or abandon(). nullptr where the policy is
  /// kProcessAll and no slot is free: wait for the writer's bell.
  Volume* begin();

  /// Writer: assigns the volume's id and passes it to the reader.
  void publish();

  /// Writer: drops the volume of begin().
  void abandon();

  /// A volume held by the reader; its slot returns to the ring on destruction. Must not outlive the ring.
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

  /// Reader: the next volume by the ring's policy (the newest, or the oldest unread), or an empty lease. The
  /// reader may hold one lease at a time.
  Lease take();

  /// Reader: saves the newest volumes that were read or skipped, at most most_kept(), until release_kept().
  /// What the reader holds in a lease is not among them. Returns them oldest first, as kept() does.
  std::span<const Volume* const> keep();
  std::span<const Volume* const> kept() const { return kept_; }
  void release_kept();
  std::uint32_t most_kept() const { return most_kept_; }

  /// Reader: whether take() would return a volume.
  bool has_published() const;

  /// Reader: the largest commit number of the frames of the volume that take() would return; nullopt: none. A
  /// frame with a larger one belongs to a later volume.
  std::optional<std::uint64_t> waiting_commit_number() const;

  const RingCounters& counters() const { return counters_; }
  std::uint32_t frame_capacity() const { return slots_.front().volume->frame_capacity(); }
  std::uint64_t capacity_bytes() const;

 private:
  // The state of a slot and the id of its volume are one atomic word, so that neither side can mistake a
  // reused slot for the one that it read before.
  enum State : std::uint64_t { kFree, kWriting, kPublished, kReading, kKept };
  static constexpr std::uint64_t kStateBits = 3;
  static constexpr std::uint64_t word(State state, std::uint64_t id) { return id << kStateBits | state; }
  static constexpr State state_of(std::uint64_t word) {
    return static_cast<State>(word & ((1U << kStateBits) - 1));
  }

  struct Slot {
    std::unique_ptr<Volume> volume;
    std::atomic<std::uint64_t> state{kFree};
    std::atomic<std::uint64_t> commit_number{0};  // largest of its frames
  };

  std::uint32_t oldest_published(std::uint64_t& seen) const { return oldest(kPublished, seen); }
  std::uint32_t oldest(State state, std::uint64_t& seen) const;
  std::uint32_t newest_free(std::uint64_t below, std::uint64_t& seen) const;
  bool take_free();
  bool too_many_wait() const;
  void release(std::uint32_t slot);

  static constexpr std::uint32_t kNone = ~0U;

  RingPolicy policy_;
  std::uint32_t most_kept_;
  Dependencies dependencies_;
  std::vector<Slot> slots_;
  RingCounters counters_;
  std::vector<const Volume*> kept_;  // reader only
  std::vector<std::uint32_t> kept_slots_;
  std::uint32_t writing_ = kNone;  // writer only
  std::uint64_t last_id_ = 0;      // writer only
};

}  // namespace fanlight
