// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/igtl/first_sweeps.hpp"
#include "acquisition/igtl/igtl_address.hpp"
#include "acquisition/igtl/igtl_connection.hpp"
#include "acquisition/igtl/image_parts.hpp"
#include "acquisition/igtl/image_shape.hpp"
#include "acquisition/igtl/pose_history.hpp"
#include "acquisition/igtl/rising_number.hpp"
#include "acquisition/source/device_clock.hpp"
#include "acquisition/source/frame_source.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/igtl/opened_message.hpp"

namespace fanlight {

/// An OpenIGTLink server as a source: PlusServer, a scanner, another Fanlight. Its 2D images (IMAGE) are the
/// frames; proto/OPENIGTLINK.md says what else is read of them. The stream never ends by itself: a connection
/// that is lost is opened again, and the frames continue. Faults are counted in IgtlCounters.
///
/// All of it runs on the thread that calls next_frame(). After the first frames it allocates nothing, except
/// where the images change their size or geometry.
class IgtlSource final : public FrameSource {
 public:
  struct Config {
    IgtlAddress address;
    std::filesystem::path geometry_path;  ///< see RecordingGeometry; empty: what the images say
    double wait_s = 5;                    ///< how long create() tries to connect; at least 0
    double learn_s = 30;                  ///< how long it then looks at images (FirstSweeps)
    double silence_s = 10;                ///< see IgtlConnection
    std::function<bool()> stopped{};      ///< asked meanwhile: whether create() shall give up; empty: never
  };

  /// Connects, and looks at the first images until their geometry is known. kNotFound: no connection within
  /// wait_s. kBadInput: no image that can be used within learn_s; others as of FirstSweeps::result().
  /// kStopped: by `stopped`. `link` must outlive the source.
  static Result<std::unique_ptr<IgtlSource>> create(const Config& config, ProbeLink& link);

  const SourceDescription& description() const override { return fan_.source; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  /// A replay at the other end that jumps leaves a gap of 64 at least.
  std::uint64_t longest_loss() const override { return 63; }
  FrameFault known_fault() const override { return announced_.fault; }
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;

 private:
  /// An image that came, in memory of its own.
  struct Held {
    std::vector<std::uint8_t> memory;  // the image refers to it
    std::vector<std::uint8_t> parts;   // and to this one, where it came in parts
    IgtlImage image;
    std::int64_t arrival_ns = 0;
    FrameFault fault = FrameFault::kNone;  // else there is no image
    bool is_there = false;
  };
  struct Announced {
    FrameStamp stamp;
    FrameFault fault = FrameFault::kNone;
  };
  IgtlSource(const Config& config, ProbeLink& link);

  // Messages.
  void take_message();
  void take_damaged();
  void begin_connection();
  bool use_message(const igtl::OpenedMessage& opened);
  void take_image(const igtl::OpenedMessage& opened);
  void take_part(const igtl::ReceivedImage& image, Held& held);
  /// For the next image: behind the held one, or in its place. Precondition: one of them is free.
  Held& free_place() { return held_.is_there ? next_ : held_; }
  void add_pose(const igtl::DeviceName& device, const igtl::GridPose& pose);
  std::int64_t sender_time_ns() const;

  // What the images are.
  /// Config::stopped, as an error.
  Result<void> not_stopped() const;
  Result<void> learn_until_known();
  /// Adds the held image. Whether the geometry is known now, and the image is a frame.
  Result<bool> learn_of_held(bool at_once);
  std::string what_came() const;
  void begin_to_learn();
  bool learn_again();
  Result<void> use(LearnedFan fan);

  // Frames.
  struct Placed {
    std::optional<double> angle_rad;  // absent: it has no place
    bool may_come = false;            // but may still get one
    bool is_outside_fan = false;      // it lies elsewhere
  };
  Placed placed(const IgtlImage& image) const;
  /// False: its pose may still come.
  bool announce();
  void look_for_another_fan();
  FrameStamp stamp_of(const FrameNotes& notes, double angle_rad);
  std::int64_t capture_time_ns(const FrameNotes& notes);
  std::uint64_t sequence_of(const FrameNotes& notes, bool is_first);
  SweepDirection direction_of(const FrameNotes& notes, double angle_rad);
  void forget_held();

  Config config_;
  IgtlCounters& counters_;
  IgtlConnection connection_;
  igtl::DeviceName device_;  // whose images are used; empty: not known yet
  PoseHistory poses_;
  ImageParts parts_;
  Held held_;  // the image to announce
  Held next_;  // and one behind it, which came while the other waits for its pose
  bool was_announced_ = false;

  std::optional<FirstSweeps> learning_;
  LearnedFan fan_;
  std::uint32_t outside_fan_ = 0;  // images, one after the other
  std::int64_t outside_fan_since_ns_ = 0;
  std::uint64_t most_frame_bytes_ = 0;  // of the first geometry, for which the ring was made
  ImageShape shape_;
  std::optional<GreyLevels> levels_;
  std::vector<std::uint8_t> grey_;  // of an image, before it is turned
  std::uint32_t geometry_revision_ = 0;
  std::string seen_;  // messages received that were no frames, for the error message

  RisingNumber sequence_{64};  // so far the assembler takes frames out of order
  RisingNumber volume_{1};     // a frame of the sweep before
  DeviceClock clock_;
  std::uint64_t arrivals_ = 0;
  FrameNotes last_;
  double last_angle_rad_ = 0;
  SweepDirection direction_ = SweepDirection::kForward;
  std::uint64_t connection_of_last_ = 0;     // of the last frame
  std::uint64_t connection_of_message_ = 0;  // of the last message
  Announced announced_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
