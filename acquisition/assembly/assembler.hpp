// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>

#include "acquisition/assembly/dropped_sweeps.hpp"
#include "acquisition/assembly/open_volume.hpp"
#include "acquisition/assembly/reversal_detector.hpp"
#include "acquisition/assembly/sequence_window.hpp"
#include "acquisition/assembly/sweep_check.hpp"
#include "acquisition/assembly/sweep_hysteresis.hpp"
#include "acquisition/assembly/sweep_thumbnails.hpp"
#include "acquisition/source/angle_check.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "proto/model/frame.hpp"
#include "proto/model/pipeline_counters.hpp"

namespace fanlight {

/// How the end of a sweep is found.
enum class SweepCut : std::uint8_t {
  kByIndex,    ///< stamps name another volume
  kByTurning,  ///< the angle reverses; the stamps' volume index, frame index and direction are not read
};

/// Whether the mismatch of forward and backward sweeps is estimated and corrected (SweepHysteresis).
enum class MismatchCorrection : std::uint8_t { kOn, kOff };

/// What was added to the angles of a volume when it was first assembled.
struct RecordedCorrection {
  std::uint64_t first_frame_sequence = 0;
  double correction_rad = 0;
};

/// Collects the frames of a sweep into a volume of the ring, for either direction of the motor.
///
/// Life of a frame: place() -> its pixels are written to the returned memory -> commit(); or reject(). A
/// frame that is placed and never committed counts as not received: the gap in the sequence counts it as
/// missing. Life of a sweep: first frame -> ... -> its last announced frame, or the first frame of another
/// sweep, or the end of the source. Frames whose angle is an outlier (AngleCheck) are removed and count as
/// invalid; with kByTurning, one may be taken for a reversal before. The volume is then published, or dropped
/// and counted: too many frames are missing or the angle jumps (incomplete), the sweep began or ended in its
/// middle (abandoned), or the angle did not move (short).
///
/// Frames may arrive out of order. A frame that arrives behind newer ones is used while its sweep is open,
/// and is late afterwards. A sequence number counts as missing when its sweep ends, when the newest frame is
/// 64 ahead of it, or when the sequence restarts. A frame that arrives after that also counts as late.
///
/// Every step is one entry of the counters' sequence lock, so their sum holds for any reader at any moment.
/// One thread, the acquisition thread. Allocates in the constructor only.
class Assembler {
 public:
  struct Config {
    SweepCut cut = SweepCut::kByIndex;
    ReversalDetector::Range range;  ///< of the motor; used with kByTurning only
    /// Largest share of a sweep's frames that a volume may lack, 0 to 1; a single frame may always be
    /// missing.
    double most_missing_share = 0.15;
    std::uint32_t longest_gap_frames = 3;  ///< longest run of missing frames
    MismatchCorrection correction = MismatchCorrection::kOn;
    /// With kOff: the corrections of these volumes, in order of their first frames. Must outlive the
    /// assembler.
    std::span<const RecordedCorrection> recorded{};
    bool checks_sweeps = true;  ///< sets VolumeStamp::warnings; off for planes that no probe swept
  };
  /// All must outlive the assembler. `writer_bell` is the bell that the ring rings when a slot becomes free.
  /// `frame_queue` receives a copy of each committed frame before its volume is published; nullptr: none.
  /// `dropped` receives each sweep that had a usable frame and gave no volume; nullptr: none.
  struct Dependencies {
    VolumeRing& ring;
    Doorbell& writer_bell;
    AcquisitionCounters& counters;
    FrameQueue* frame_queue = nullptr;
    DroppedSweeps* dropped = nullptr;
  };

  explicit Assembler(const Dependencies& dependencies);
  Assembler(const Dependencies& dependencies, const Config& config);
  /// Abandons the open sweep.
  ~Assembler();
  Assembler(const Assembler&) = delete;
  Assembler& operator=(const Assembler&) = delete;

  /// Memory of the ring for this frame: rows x columns bytes of `geometry`, row major. It must be filled
  /// before commit() and not written after it. `geometry` belongs to the stamp's revision. Empty where the
  /// frame cannot be used (repeated, late, an unusable angle, a full volume, a geometry that the volume
  /// cannot hold); the frame is then counted, and the caller continues with the next one. Blocks only where
  /// the ring processes all volumes and has no free slot. If `stop` ends that wait, the result is empty and
  /// the frame is not counted.
  std::span<std::uint8_t> place(const FrameStamp& frame, const FanGeometry& geometry,
                                const std::stop_token& stop);

  /// Counts the frame of the last place() as part of its volume, assigns its commit number, and copies it to
  /// the queue. Never blocks: a full queue drops the copy.
  void commit();

  /// Counts an unusable frame, whether it was placed or not; it may still be the last of its sweep.
  /// Precondition: `fault` is not kNone.
  void reject(const FrameStamp& frame, FrameFault fault);

  /// Publishes the open sweep with the frames so far: no other frame will follow. Where the source announced
  /// many more, it is dropped as cut off.
  void end_of_source();

  /// Drops the open sweep; its frames count as abandoned.
  void abandon();

  /// Frames committed, in a volume that is neither published nor dropped.
  std::uint32_t frames_pending() const { return pending_; }

 private:
  using Arrival = SequenceWindow::Arrival;
  struct Sweep {
    std::uint64_t index = 0;
    bool known = false;     // index is valid
    bool finished = false;  // its last announced frame has arrived, or the source has ended
    SweepDirection direction = SweepDirection::kForward;            // from the angles; with kByTurning only
    std::uint64_t end = std::numeric_limits<std::uint64_t>::max();  // sequence number after its last frame
    std::uint32_t announced = 0;                                    // number of frames; 0: not known
    std::uint64_t cut_off =
        0;  // frames that its volume cannot have, because the sweep began or ended in its middle
    SequenceGaps gaps;
  };

  Arrival classify(const FrameStamp& frame);
  bool accepts(const FrameStamp& frame) const;
  void restart_sequence(std::uint64_t sequence);
  void follow_geometry(const FrameStamp& frame);
  void cut_off_below(std::uint64_t frames);
  void enter_sweep_of(const FrameStamp& frame);
  void leave_sweep_after(const FrameStamp& frame);
  void follow_angle(const FrameStamp& frame, const std::stop_token& stop);
  void end_sweep_at_reversal(const std::stop_token& stop);

  AngleCheck::Findings remove_outliers();
  std::optional<DroppedSweep::Reason> reason_to_drop(double gap_rad) const;
  void drop(DroppedSweep::Reason reason, const AngleCheck::Findings& angles);
  void finish_volume();
  void check_sweep();
  void publish();
  void correct_as_recorded();

  void mark(const FrameStamp& frame, SequenceWindow::Frame use);
  void settle_below(std::uint64_t sequence);
  void count_unplaced(Counter& reason);
  void settle_pending(Counter& fate, std::uint32_t frames);
  Counter& faults(FrameFault fault);

  Dependencies dependencies_;
  Config config_;
  SequenceWindow window_;
  ReversalDetector reversal_;
  SweepThumbnails thumbnails_;  // of the volume that is published
  SweepCheck check_;
  std::optional<SweepHysteresis> hysteresis_;
  OpenVolume volume_;  // of the open sweep; not open before its first usable frame
  std::uint32_t pending_ = 0;
  std::uint64_t committed_ = 0;  // frames since construction
  std::optional<FrameStamp> placed_;
  Arrival placed_arrival_ = Arrival::kNewest;
  Sweep sweep_;
  std::uint32_t last_sweep_frames_ = 0;  // of the last sweep published
  std::optional<std::uint32_t> geometry_revision_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
