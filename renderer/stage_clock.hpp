#pragma once

#include <array>
#include <cstdint>

#include "proto/picture.hpp"
#include "proto/result.hpp"
#include "renderer/device_handle.hpp"
#include "renderer/gpu.hpp"

namespace fanlight {

/// When a stage of a picture ran, on the device's clock, ns; both 0 where it did not.
struct StageSpan {
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
};

/// Time stamps that the GPU writes as it works on a slot's picture, each before or after a stage. Render
/// thread only.
class StageClock {
 public:
  enum Moment : std::uint32_t {
    kPrepareBegin,
    kPrepareEnd,
    kUploadBegin,
    kCastBegin,
    kCastEnd,
    kFilterBegin,
    kLightBegin,
    kLightEnd,
    kFinishEnd,
    kReadBackEnd,
    kMoments
  };

  static Result<StageClock> create(const Gpu& gpu);

  /// Forgets all moments. Precondition: the GPU writes none.
  void reset(const Gpu& gpu) const;

  /// Records that the moment has come when all before it is done.
  void stamp(VkCommandBuffer commands, Moment moment) const;

  /// When each stage ran; nothing for those whose moments were not written since reset(). Precondition: the
  /// GPU writes none.
  std::array<StageSpan, kStages> spans(const Gpu& gpu) const;

  /// The same in milliseconds.
  std::array<double, kStages> ms(const Gpu& gpu) const;

 private:
  QueryPoolHandle times_;
};

}  // namespace fanlight
