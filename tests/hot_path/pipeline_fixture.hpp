// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "server/pipeline/pipeline.hpp"
#include "tests/hot_path/hot_threads.hpp"

namespace fanlight::test {

/// A source and the pipeline of `fanlight serve`. The test is in the place of the server: it reads pictures
/// and publishes scenes. Test thread only.
class PipelineFixture {
 public:
  /// Starts the two threads. They are not hot yet. Throws where there is no GPU. `recordings`: a folder to
  /// which all frames are recorded; empty: none are.
  PipelineFixture(FrameSource& source, RingPolicy policy, const std::filesystem::path& recordings = {});

  /// The recorder's newest state. Precondition: there is a folder for recordings.
  RecordingStatus recording();

  /// The scene that shows all of the source.
  const Scene& suggested() const { return suggested_; }

  /// Publishes a scene for the renderer and returns its revision.
  std::uint64_t show(const Scene& scene);

  /// Waits for a picture that was not read yet, and returns the newest one. Throws if none comes within half
  /// a minute, or if a thread has failed or ended.
  const Picture& next_picture();

  /// Makes both threads hot until the fixture is destroyed.
  void make_hot();

  std::int64_t started_ns() const { return started_ns_; }
  const RenderCounters& counters() const { return pipeline_->counters().render; }

 private:
  const Scene suggested_;
  std::uint64_t revision_ = 1;
  SourceLink link_;
  RecordingStatus recording_;
  std::unique_ptr<Pipeline> pipeline_;
  std::optional<PipelinePorts> ports_;
  std::int64_t started_ns_ = 0;
  std::vector<pid_t> thread_ids_;
  // Destroyed first: the end of a thread is not part of the hot path.
  std::vector<std::unique_ptr<HotThread>> hot_threads_;
};

}  // namespace fanlight::test
