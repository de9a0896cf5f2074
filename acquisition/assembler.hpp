#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "acquisition/sequence_window.hpp"
#include "acquisition/sweep_mismatch.hpp"
#include "acquisition/turning_finder.hpp"
#include "proto/counter.hpp"
#include "proto/doorbell.hpp"
#include "proto/frame.hpp"
#include "proto/frame_feed.hpp"
#include "proto/volume_ring.hpp"

namespace fanlight {

/// Where a sweep ends.
enum class SweepCut : std::uint8_t {
  kByIndex,    ///< where stamps name another volume
  kByTurning,  ///< where the angle turns; stamps' volume, place in the sweep and direction are not read
};

/// Whether the disagreement of forward and backward sweeps is looked for and taken out (SweepMismatch).
enum class MismatchCorrection : std::uint8_t { kOn, kOff };

/// Turns the frames of a sweep into a volume of the ring, in whichever direction the motor went.
///
/// Life of a frame: place() -> its pixels written to the memory named -> commit(); or reject(). A frame that
/// is placed and never committed was never received: the gap in the sequence counts it as missing.
/// Life of a sweep: first frame -> ... -> its last announced frame, or the first of another sweep, or the
/// end of the source. It is then published, or dropped and counted: too many of its frames are missing
/// (incomplete), it began or ended amidst (abandoned), its angle did not move (short).
///
/// Frames may come out of order: one that comes behind others is used while its sweep is open, and is late
/// afterwards. A number of the sequence counts as missing when its sweep ends, or when the newest frame is 64
/// ahead of it, or when the sequence breaks off; a frame that still comes then counts as late besides.
///
/// Every step is one entry of the counters' ledger, so their sum holds for who reads it at any moment.
/// One thread, the acquisition thread. After construction it allocates nothing.
class Assembler {
 public:
  struct Config {
    SweepCut cut = SweepCut::kByIndex;
    TurningFinder::Range range;  ///< of the motor; read with kByTurning alone
    /// A volume may lack this share of its sweep's frames, or a single one; 0 to 1.
    double most_missing_share = 0.15;
    std::uint32_t longest_gap_frames = 3;  ///< and no more of them in a row
    MismatchCorrection correction = MismatchCorrection::kOn;
  };
  /// All must outlive the assembler. `writer_bell` is the one that the ring rings when a slot comes free;
  /// `feed` gets each committed frame as well, before its volume is published, and is null where nobody wants
  /// frames ahead.
  struct Dependencies {
    VolumeRing& ring;
    Doorbell& writer_bell;
    AcquisitionCounters& counters;
    FrameFeed* feed = nullptr;
  };

  explicit Assembler(const Dependencies& dependencies);
  Assembler(const Dependencies& dependencies, const Config& config);
  /// Abandons the sweep under way.
  ~Assembler();
  Assembler(const Assembler&) = delete;
  Assembler& operator=(const Assembler&) = delete;

  /// The ring's memory for this frame (rows x columns bytes of `geometry`, row major), to be filled before
  /// commit() and not touched after it. `geometry` is that of the stamp's revision. Empty where the frame has
  /// no place (repeated, late, an unusable angle, a volume that is full or cannot hold the geometry): it is
  /// counted, go on with the next. Waits only where the ring processes all volumes and has no room; empty as
  /// well, and nothing counted of this frame, when `stop` ends that wait.
  std::span<std::uint8_t> place(const FrameStamp& frame, const FanGeometry& geometry,
                                const std::stop_token& stop);

  /// Counts the frame just placed as part of its volume, gives it its number of arrival and feeds it. Never
  /// waits: a full feed goes without it.
  void commit();

  /// Counts a frame that is of no use, placed before or not; it can still be the last of its sweep.
  /// Precondition: `fault` is one.
  void reject(const FrameStamp& frame, FrameFault fault);

  /// Publishes the sweep under way as far as it came: no other frame will follow.
  void end_of_source();

  /// Gives the sweep under way up; its frames count as abandoned.
  void abandon();

  /// Frames committed and neither published nor dropped yet.
  std::uint32_t frames_pending() const { return pending_; }

 private:
  using Arrival = SequenceWindow::Arrival;
  struct Sweep {
    std::uint64_t index = 0;
    bool known = false;     // index means something
    bool finished = false;  // its last announced frame has come, or the source has ended
    SweepDirection direction = SweepDirection::kForward;  // as the angle tells; with kByTurning alone
    std::uint64_t end = std::numeric_limits<std::uint64_t>::max();  // the number after its last frame's
    std::uint32_t announced = 0;                                    // frames; 0 where not known
    std::uint64_t cut_off = 0;  // frames that its volume cannot have, since it began or ended amidst
    SequenceGaps gaps;
  };
  enum class Verdict : std::uint8_t { kGood, kIncomplete, kCutOff, kShort };

  Arrival arrive(const FrameStamp& frame);
  bool open_for(const FrameStamp& frame) const;
  void begin_anew(std::uint64_t sequence);
  void follow_geometry(const FrameStamp& frame);
  void enter_sweep_of(const FrameStamp& frame);
  void leave_sweep_after(const FrameStamp& frame);
  void follow_angle(const FrameStamp& frame, const std::stop_token& stop);
  void end_sweep_at_turn(const std::stop_token& stop);
  void carry_over(const Volume& ended, std::uint32_t first, std::uint32_t frames,
                  const std::stop_token& stop);

  bool open_volume(const FanGeometry& geometry, const std::stop_token& stop);
  Volume* wait_for_volume(const std::stop_token& stop);
  Verdict verdict() const;
  void finish_volume();
  void publish();

  void mark(const FrameStamp& frame, SequenceWindow::Frame use);
  void settle_below(std::uint64_t sequence);
  void count_unplaced(Counter& reason);
  void settle_pending(Counter& fate, std::uint32_t frames);
  Counter& faults(FrameFault fault);

  Dependencies dependencies_;
  Config config_;
  SequenceWindow window_;
  TurningFinder finder_;
  std::optional<SweepMismatch> mismatch_;
  Volume* volume_ = nullptr;        // of the sweep under way, from its first usable frame on
  std::vector<FrameStamp> stamps_;  // of its frames, in order of arrival
  std::uint32_t pending_ = 0;
  std::uint64_t committed_ = 0;  // frames, ever
  std::optional<FrameStamp> placed_;
  Arrival placed_arrival_ = Arrival::kNewest;
  Sweep sweep_;
  std::uint32_t last_sweep_frames_ = 0;  // of the last sweep published
  std::optional<std::uint32_t> geometry_revision_;
};

}  // namespace fanlight
