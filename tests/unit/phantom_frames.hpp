// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "acquisition/phantom/phantom_source.hpp"

namespace fanlight::test {

/// Linear: the theory of its speckle is known.
inline constexpr PhantomSource::Config kSpeckled = {.clutter = PhantomSource::Clutter::kOff,
                                                    .scale = {.kind = EchoScale::Kind::kLinear},
                                                    .pace = PhantomSource::Pace::kUnpaced};

struct Frame {
  FrameStamp stamp;
  std::vector<std::uint8_t> pixels;
};

inline std::unique_ptr<PhantomSource> make(const PhantomSource::Config& config) {
  auto source = PhantomSource::create(config);
  if (!source) {
    ADD_FAILURE() << source.error().message;
    return nullptr;
  }
  return *std::move(source);
}

inline FrameStamp next_stamp(PhantomSource& source) {
  const auto frame = source.next_frame({});
  return frame.value().value();
}

inline Frame next(PhantomSource& source) {
  Frame frame{.stamp = next_stamp(source),
              .pixels = std::vector<std::uint8_t>(source.description().geometry.frame_bytes())};
  source.read_pixels(frame.pixels, {});
  return frame;
}

}  // namespace fanlight::test
