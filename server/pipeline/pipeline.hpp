// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/record/recorder.hpp"
#include "proto/base/result.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/exchange/frame_tap.hpp"
#include "proto/exchange/pipeline_ports.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/exchange/pulse.hpp"
#include "proto/exchange/replay_link.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/scene.hpp"
#include "renderer/render_thread.hpp"
#include "renderer/vulkan/render_device.hpp"

namespace fanlight {

/// What the acquisition thread and the server thread share about the source. Created before the source,
/// because a USB probe uses the link.
struct SourceLink {
  Doorbell acquisition_bell;  ///< wakes the acquisition thread
  Doorbell server_bell;       ///< wakes the server thread
  ProbeLink probe{acquisition_bell, server_bell};
  ReplayLink replay{server_bell};
};

/// The acquisition thread and the render thread with everything that they exchange between them and with the
/// server thread: ring of volumes, frame queue, mailboxes, bells and counters. The three threads share
/// nothing else. The member functions belong to the server thread.
class Pipeline {
 public:
  struct Config {
    PictureSize size;
    PictureSize largest_size;  ///< for displays that ask for more
    Scene scene;               ///< the first one; it gets revision 1
    std::uint32_t ring_slots = 4;
    std::uint32_t cine_volumes = 0;  ///< further slots of the ring, for the last volumes
    RingPolicy policy = RingPolicy::kNewestWins;
    MismatchCorrection mismatch = MismatchCorrection::kOn;
    PipelineCache::Config pipeline_cache{};      ///< see Renderer::Config; by default there is no file
    std::string gpu;                             ///< part of the GPU's name; empty for the best one
    std::optional<Watchdog::Limits> watchdog{};  ///< see Renderer::Config
    Recorder::Config recordings{};  ///< where recordings go; without a folder nothing is recorded
    bool sends_frames = false;      ///< the server may send the source's frames: see frame_tap()
    /// create() starts the acquisition thread of a live source before it opens the device, so that the first
    /// volume is there when the renderer is. Volumes that come too early are replaced by newer ones, and
    /// counted as dropped.
    bool acquires_early = false;
  };
  /// Opens a device by a part of its GPU's name. Called again, on the render thread, where the device was
  /// lost.
  using OpenDevice = std::function<Result<RenderDevice>(const std::string& name)>;
  /// All must outlive the pipeline.
  struct Dependencies {
    OpenDevice open_device;
    FrameSource& source;
    SourceLink& link;
  };

  /// Opens the device, and allocates the ring, the queue, the mailboxes and the renderer. Starts the recorder
  /// where there is one, and acquisition by Config::acquires_early. Errors: those of the device and
  /// Renderer::create's.
  static Result<std::unique_ptr<Pipeline>> create(const Config& config, const Dependencies& dependencies);
  ~Pipeline() = default;
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// Starts both threads, or the one that does not run yet. Call it once.
  void start();

  /// Time within which stop() returns, except for a source that does not stop: the process must end within a
  /// second after its signal.
  static constexpr std::int64_t kMostStopNs = 700'000'000;

  /// Ends both threads. The counters stay. False where the GPU's driver does not let go: a thread is inside
  /// it, and the process must end by std::_Exit, without the destructor. The destructor does the same without
  /// a limit.
  bool stop();

  /// All GPUs of this machine, and the one that was opened first.
  const std::vector<GpuCandidate>& gpus() const { return gpus_; }
  const GpuCandidate& gpu() const { return gpu_; }

  /// "running", "ended", or the sentence why the source failed. "ended" too before acquisition is started and
  /// after stop().
  std::string source_state() const;

  /// The server thread's ends of all that it exchanges with the pipeline. The frame tap is absent where the
  /// configuration says that no frames are sent, the recorder without a folder for recordings.
  PipelinePorts ports();
  const Pulse& acquisition_pulse() const { return acquisition_pulse_; }
  const Pulse& render_pulse() const { return render_link_.pulse; }

  PipelineCounters counters() const {
    return {acquisition_counters_, ring_.counters(),     queue_.counters(),
            render_counters_,      link_.probe.counters, link_.probe.igtl};
  }
  std::uint64_t ring_capacity_bytes() const { return ring_.capacity_bytes(); }

 private:
  Pipeline(const Config& config, const Dependencies& dependencies);
  void start_acquisition();
  Result<void> open(const Config& config);
  Result<DeviceRenderer> make_renderer(RenderDevice device, const NumberedScene& scene);
  Result<DeviceRenderer> remake(const NumberedScene& scene);

  OpenDevice open_device_;
  std::string gpu_wanted_;
  Renderer::Config renderer_config_;
  std::vector<GpuCandidate> gpus_;
  GpuCandidate gpu_;
  FrameSource& source_;
  SourceLink& link_;
  MismatchCorrection mismatch_;
  Doorbell render_bell_;
  AcquisitionCounters acquisition_counters_;
  RenderCounters render_counters_;
  VolumeRing ring_;
  FrameQueue queue_;
  RenderLink render_link_;
  Pulse acquisition_pulse_;
  std::optional<Recorder> recorder_;
  std::optional<FrameTap> sent_frames_;
  DeviceRenderer renderer_;  // null from start() on: the render thread owns it
  // Last: the threads use the members above.
  std::optional<RenderThread> render_thread_;
  std::optional<AcquisitionThread> acquisition_thread_;
};

}  // namespace fanlight
