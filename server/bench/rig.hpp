// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/private_view.hpp"
#include "proto/model/picture.hpp"
#include "renderer/renderer.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

/// Measures one renderer with the work of a row. One thread.
class BenchRig {
 public:
  /// The work must outlive the rig. The scene is copied.
  BenchRig(const RenderDevice& device, BenchWork& work)
      : device_(device),
        volumes_(work.volumes),
        scene_{.revision = 1, .scene = work.scene},
        picture_(work.picture) {}

  Result<void> start(Skipping skipping, Counting counting = Counting::kOff);

  // Each returns the time from the call to the finished picture in ms.

  /// Loads the whole next volume at once.
  Result<double> whole_volume();

  /// Only the last frame of the next volume is new; all others were taken before. Precondition: there was a
  /// volume before it, because the renderer accepts frames ahead only then.
  Result<double> new_volume();

  /// Takes the frames of the next sweep one by one, with a picture for each.
  Result<std::vector<double>> rolling_sweep();

  /// Changes the scene; `sign` alternates between 1 and -1.
  Result<double> change(void (*how)(Scene&, double sign));

  /// What a private view has of its own.
  enum class PrivateKind : std::uint8_t { kCamera, kLight };
  /// Opens this number of private views of the volume on show and waits for a picture of each. Precondition:
  /// a picture was shown.
  Result<double> private_pictures(std::size_t views, PrivateKind kind);

  const Picture& picture() const { return shown_; }
  Renderer& renderer() { return *renderer_; }

 private:
  Result<void> take(std::uint32_t index);
  Result<double> picture_since(std::int64_t from_ns);

  const RenderDevice& device_;
  BenchVolumes& volumes_;
  NumberedScene scene_;
  int picture_;
  double sign_ = 1;
  RenderCounters counters_;
  // Of private views; the renderer writes to them.
  Doorbell private_bell_;
  std::array<std::optional<Mailbox<Picture>>, kMostPrivateViews> private_pictures_;
  std::unique_ptr<Renderer> renderer_;
  Picture shown_;
  std::uint64_t private_view_id_ = 0;
};

}  // namespace fanlight
