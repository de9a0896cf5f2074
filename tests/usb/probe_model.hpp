// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/model/probe_protocol.hpp"
#include "tests/usb/fault.hpp"
#include "tests/usb/probe_pictures.hpp"

namespace fanlight::test {

/// A probe without a bus: answers the requests of proto/usb_probe.md and fills bulk transfers with frames of
/// the simulated scene. Time is a parameter and must not decrease. No thread and no clock; all calls come
/// from one thread.
///
/// Life: stopped -> start request -> captures frames as time advances -> stop request or unplugged() ->
/// stopped.
class ProbeModel {
 public:
  struct Config {
    std::string serial = "0001";
    double frame_rate_hz = 20;             ///< 0.1 to 100 000
    std::uint32_t frames_per_volume = 35;  ///< 2 to 1024, until set by the host
    std::uint32_t columns = 512;           ///< 16 to 4096, over 160 mm
    std::uint32_t rows = 512;              ///< 16 to 4096, at the full depth of 160 mm
    double sweep_deg = 70;                 ///< 1 to 170, until set by the host
    double depth_mm = 160;       ///< 20 to 160, rounded to whole rows: a smaller depth has fewer rows
    bool counts_volumes = true;  ///< false: headers contain no sweep information, not even the direction
    /// Mismatch of forward and backward, -4 to 4: the angle in the header is that of the pixels minus half of
    /// this in a forward frame, plus half of this in a backward frame.
    double lag_deg = 0;
    bool ends_transfers = true;  ///< false: violates that rule of the protocol
    /// Frames buffered while the host reads none, besides the one being sent; 0: 50 ms of frames, at least 2.
    std::uint32_t room_frames = 0;
    bool prepared = false;   ///< see ProbePictures; drawn by create()
    std::uint64_t seed = 1;  ///< of the speckle and of the noise
  };

  /// Always frames_taken == frames_sent + frames_dropped + frames_withheld + frames_torn + waiting().
  struct Counters {
    std::uint64_t frames_taken = 0;
    std::uint64_t frames_sent = 0;      ///< sent to the last byte, including damaged and flagged ones
    std::uint64_t frames_dropped = 0;   ///< no free buffer, or left over at start, stop or unplug
    std::uint64_t frames_withheld = 0;  ///< by the faults drop and random
    std::uint64_t frames_torn = 0;      ///< begun and not sent to the end: cut, stall, error, stop, unplug
    // Executed faults.
    std::uint64_t repeats = 0;  ///< frames sent again
    std::uint64_t swaps = 0;
    std::uint64_t damaged = 0;  ///< in the pixels
    std::uint64_t damaged_headers = 0;
    std::uint64_t invalid = 0;
    std::uint64_t noise_bytes = 0;
    // Totals.
    std::uint64_t bytes = 0;   ///< put into transfers
    std::uint64_t starts = 0;  ///< start requests

    bool operator==(const Counters&) const = default;
  };

  /// Result of fill().
  struct Filled {
    std::size_t bytes = 0;
    bool ended = false;  ///< by a short or empty packet: the transfer is complete, full or not
  };

  /// kInvalidArgument where a value is out of its range.
  static Result<std::unique_ptr<ProbeModel>> create(const Config& config);

  /// The whole answer, of which the caller sends the requested length; nullopt: STALL. `request` is bRequest;
  /// the caller has checked that it is a vendor request to interface 0.
  std::optional<std::vector<std::uint8_t>> control_in(std::uint8_t request) const;
  /// False: STALL, without a change. Sweep, frames and depth take effect with the first frame of the next
  /// sweep, or at start.
  bool control_out(std::uint8_t request, std::span<const std::uint8_t> data, std::int64_t now_ns);

  /// Writes the next bytes to `to`, the rest of a transfer's buffer: up to the end of a frame, or as many as
  /// are available, possibly none (NAK). Captures the due frames first.
  Filled fill(std::span<std::uint8_t> to, std::int64_t now_ns);
  /// The bytes of the last fill() did not arrive: their frame counts as torn.
  void lose_last_fill();
  /// Drops the rest of the frame being sent.
  void tear();

  /// Captures the due frames, and drops the oldest where no buffer is free.
  void advance(std::int64_t now_ns);
  /// Time from which data is available, possibly in the past; nullopt while stopped.
  std::optional<std::int64_t> ready_at_ns() const;

  /// A fault of a frame or of the stream. Faults of the bus are ignored.
  void inject(const Fault& fault, std::int64_t now_ns);
  /// Loss of power: stopped, buffers empty, settings and geometry as configured. The counters remain.
  void unplugged();

  bool streaming() const { return streaming_; }
  bool between_frames() const { return !under_way_ && !owes_empty_packet_; }
  /// Frames that reached the pipe since construction; including withheld ones, without repeats.
  std::uint64_t frames_offered() const { return frames_offered_; }
  std::uint64_t waiting() const;  ///< captured frames not sent to their last byte
  const Counters& counters() const { return counters_; }
  const Config& config() const { return config_; }
  probe::Geometry geometry() const;  ///< of the next captured frame, unless a setting changes it

 private:
  /// A captured frame that is not drawn yet, so that dropping it costs nothing.
  struct Taken {
    probe::FrameHeader header;  ///< all but the payload's checksum
    std::shared_ptr<ProbePictures> pictures;
    std::uint64_t picture = 0;
    std::uint32_t rows = 0;
  };
  enum class Fate : std::uint8_t { kSent, kTorn, kWithheld, kRepeat };
  /// Data on the pipe: `front`, then `pixels`.
  struct UnderWay {
    std::vector<std::uint8_t> front;  ///< noise and header
    std::span<const std::uint8_t> pixels;
    std::vector<std::uint8_t> own_pixels;  ///< holds `pixels`, unless they are the pictures'
    std::shared_ptr<ProbePictures> pictures;
    std::size_t sent_bytes = 0;
    std::size_t noise_bytes = 0;  ///< in `front`
    bool ends_transfer = true;
    bool repeat = false;
    Fate fate = Fate::kSent;

    std::size_t size() const { return front.size() + pixels.size(); }
  };
  /// Faults for the next frame on the pipe.
  struct Pending {
    bool drop = false;
    bool invalid = false;
    bool misfit = false;
    bool damage = false;
    bool damage_header = false;
    bool cut = false;
    bool repeat = false;
    bool swap = false;
    std::uint32_t noise_bytes = 0;
  };

  ProbeModel(const Config& config, std::shared_ptr<ProbePictures> pictures);

  bool set(probe::Request setting, std::uint32_t value);
  void start(std::int64_t now_ns);
  void stop();
  void forget_frames();
  void begin_first_sweep();
  void apply_settings();
  std::uint32_t rows_of(double depth_mm) const;
  void change_depth(std::uint32_t rows);
  void take(std::int64_t due_ns);
  std::int64_t due_ns(std::uint64_t frame) const;

  bool begin_next();
  void hold_back(UnderWay frame);
  UnderWay drawn(const Taken& frame);
  UnderWay random_bytes(std::size_t bytes);
  void put_noise(std::vector<std::uint8_t>& to, std::size_t bytes);
  std::size_t copy_under_way(std::span<std::uint8_t> to);
  void settle(Fate fate);

  Config config_;
  std::uint32_t room_frames_;
  std::shared_ptr<ProbePictures> pictures_;
  probe::Settings set_;     // by the host; in force with the next sweep
  probe::Settings active_;  // its sweep and frames are those of pictures_
  std::uint32_t active_rows_;
  std::uint32_t geometry_revision_ = 1;

  bool streaming_ = false;
  std::int64_t started_ns_ = 0;
  std::optional<std::int64_t> powered_ns_;  // zero of the probe's own clock
  std::uint64_t taken_since_start_ = 0;     // due ones
  std::uint64_t sequence_ = 0;              // of the next frame
  std::uint64_t picture_ = 0;               // number of its picture
  std::uint64_t first_sweep_ = 0;           // of pictures_, corresponds to volume index first_volume_
  std::uint64_t first_volume_ = 0;
  std::deque<Taken> queue_;

  std::optional<UnderWay> under_way_;
  std::optional<UnderWay> held_;  // by swap, until its successor is sent
  bool successor_sent_ = false;
  std::optional<Fate> last_fate_;  // of the frame that ended in the last fill()
  bool owes_empty_packet_ = false;
  Pending pending_;
  bool random_ = false;
  std::int64_t silent_until_ns_ = 0;
  std::uint64_t frames_offered_ = 0;
  std::mt19937_64 noise_;
  Counters counters_;
};

}  // namespace fanlight::test
