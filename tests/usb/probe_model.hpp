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

#include "proto/probe_protocol.hpp"
#include "proto/result.hpp"
#include "tests/usb/fault.hpp"
#include "tests/usb/probe_pictures.hpp"

namespace fanlight::test {

/// A probe without its bus: it answers the requests of proto/usb_probe.md and fills bulk transfers with the
/// frames of the simulated scene. Time is passed in and must not go back; it has no thread and no clock, and
/// all calls come from one thread.
///
/// Life: stopped -> start request -> takes frames as time goes on -> stop request or unplugged() -> stopped.
class ProbeModel {
 public:
  struct Config {
    std::string serial = "0001";
    double frame_rate_hz = 20;             ///< 0.1 to 100 000
    std::uint32_t frames_per_volume = 35;  ///< 2 to 1024, until the host sets another
    std::uint32_t columns = 512;           ///< 16 to 4096, over 160 mm
    std::uint32_t rows = 512;              ///< 16 to 4096, at the full depth of 160 mm
    double sweep_deg = 70;                 ///< 1 to 170, until the host sets another
    double depth_mm = 160;       ///< 20 to 160, rounded to whole rows: a smaller one has fewer of them
    bool counts_volumes = true;  ///< otherwise frames say nothing of their sweep, not even its direction
    /// By how much forward and backward disagree, -4 to 4: a forward frame's angle in its header is the one
    /// that its pixels were taken at less half of this, a backward frame's that and half of this.
    double lag_deg = 0;
    bool ends_transfers = true;  ///< false: a probe that breaks that rule
    /// Frames kept while the host takes none, besides the one under way; 0: those of 50 ms, at least 2.
    std::uint32_t room_frames = 0;
    bool prepared = false;   ///< see ProbePictures; drawn by create()
    std::uint64_t seed = 1;  ///< of the speckle and of the noise
  };

  /// At any time frames_taken == frames_sent + frames_dropped + frames_withheld + frames_torn + waiting().
  struct Counters {
    std::uint64_t frames_taken = 0;
    std::uint64_t frames_sent = 0;      ///< to the last byte; damaged and flagged ones too
    std::uint64_t frames_dropped = 0;   ///< for want of room, or left behind at start, stop and unplug
    std::uint64_t frames_withheld = 0;  ///< by the faults drop and random
    std::uint64_t frames_torn = 0;      ///< begun, and not all of it sent: cut, stall, error, stop, unplug
    // What was carried out of the faults.
    std::uint64_t repeats = 0;  ///< frames sent once more
    std::uint64_t swaps = 0;
    std::uint64_t damaged = 0;  ///< in the pixels
    std::uint64_t damaged_headers = 0;
    std::uint64_t invalid = 0;
    std::uint64_t noise_bytes = 0;
    // Of all.
    std::uint64_t bytes = 0;   ///< put into transfers
    std::uint64_t starts = 0;  ///< start requests

    bool operator==(const Counters&) const = default;
  };

  /// What fill() put into a transfer.
  struct Filled {
    std::size_t bytes = 0;
    bool ended = false;  ///< by a short or an empty packet: the transfer is complete, full or not
  };

  /// kInvalidArgument where a value is out of its range.
  static Result<std::unique_ptr<ProbeModel>> create(const Config& config);

  /// The answer in full, of which the caller sends as much as was asked for; nullopt: STALL. `request` is
  /// bRequest; the caller has checked that it is a vendor request to interface 0.
  std::optional<std::vector<std::uint8_t>> control_in(std::uint8_t request) const;
  /// false: STALL, and nothing changed. Sweep, frames and depth come into force with the first frame of the
  /// next sweep, or at start.
  bool control_out(std::uint8_t request, std::span<const std::uint8_t> data, std::int64_t now_ns);

  /// Puts what there is to send into `to`, the rest of a transfer's buffer: all of it, up to the end of a
  /// frame, or as much as there is, perhaps nothing (NAK). Takes the frames that are due before.
  Filled fill(std::span<std::uint8_t> to, std::int64_t now_ns);
  /// The bytes of the last fill() did not arrive: the frame that they were of counts as torn.
  void lose_last_fill();
  /// The rest of the frame under way is lost.
  void tear();

  /// Takes the frames that are due, and drops the oldest where there is no room.
  void advance(std::int64_t now_ns);
  /// From when on there is something to send; nullopt while stopped. May lie in the past.
  std::optional<std::int64_t> ready_at_ns() const;

  /// A fault of a frame or of the stream. One of the bus is not for the model, and changes nothing.
  void inject(const Fault& fault, std::int64_t now_ns);
  /// Without power: stopped, nothing kept, settings and geometry as configured. The counters stay.
  void unplugged();

  bool streaming() const { return streaming_; }
  bool between_frames() const { return !under_way_ && !owes_empty_packet_; }
  /// Frames whose turn on the pipe came, since construction; withheld ones too, repeats not.
  std::uint64_t frames_offered() const { return frames_offered_; }
  std::uint64_t waiting() const;  ///< frames taken and not yet sent to their last byte
  const Counters& counters() const { return counters_; }
  const Config& config() const { return config_; }
  probe::Geometry geometry() const;  ///< of the frame taken next, unless a setting changes it

 private:
  /// A frame that was taken and not drawn yet: one that is dropped costs nothing.
  struct Taken {
    probe::FrameHeader header;  ///< all but the payload's checksum
    std::shared_ptr<ProbePictures> pictures;
    std::uint64_t picture = 0;
    std::uint32_t rows = 0;
  };
  enum class Fate : std::uint8_t { kSent, kTorn, kWithheld, kRepeat };
  /// What is on the pipe: `front`, then `pixels`.
  struct UnderWay {
    std::vector<std::uint8_t> front;  ///< noise and header
    std::span<const std::uint8_t> pixels;
    std::vector<std::uint8_t> own_pixels;  ///< that `pixels` is of, where they are not the pictures'
    std::shared_ptr<ProbePictures> pictures;
    std::size_t sent_bytes = 0;
    std::size_t noise_bytes = 0;  ///< of the front
    bool ends_transfer = true;
    bool repeat = false;
    Fate fate = Fate::kSent;

    std::size_t size() const { return front.size() + pixels.size(); }
  };
  /// Faults that wait for the next frame on the pipe.
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
  probe::Settings active_;  // sweep and frames are those of pictures_
  std::uint32_t active_rows_;
  std::uint32_t geometry_revision_ = 1;

  bool streaming_ = false;
  std::int64_t started_ns_ = 0;
  std::optional<std::int64_t> powered_ns_;  // where the probe's own clock began
  std::uint64_t taken_since_start_ = 0;     // those that came due
  std::uint64_t sequence_ = 0;              // of the next frame
  std::uint64_t picture_ = 0;               // that it will show
  std::uint64_t first_sweep_ = 0;           // of pictures_, that has volume index first_volume_
  std::uint64_t first_volume_ = 0;
  std::deque<Taken> queue_;

  std::optional<UnderWay> under_way_;
  std::optional<UnderWay> held_;  // by swap, until its successor is sent
  bool successor_sent_ = false;
  std::optional<Fate> last_fate_;  // of what ended in the last fill()
  bool owes_empty_packet_ = false;
  Pending pending_;
  bool random_ = false;
  std::int64_t silent_until_ns_ = 0;
  std::uint64_t frames_offered_ = 0;
  std::mt19937_64 noise_;
  Counters counters_;
};

}  // namespace fanlight::test
