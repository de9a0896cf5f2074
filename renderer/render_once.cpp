// SPDX-License-Identifier: Apache-2.0
#include "renderer/render_once.hpp"

namespace fanlight {

Result<Picture> render_once(Renderer& renderer, const Volume& volume) {
  if (auto loaded = renderer.load(volume); !loaded) return loaded.error();
  Picture picture;
  for (;;) {
    if (auto advanced = renderer.advance(); !advanced) return advanced.error();
    if (renderer.collect(picture)) return picture;
    if (!renderer.busy())
      return Error{ErrorCode::kUnavailable, "the GPU made no picture of the volume, expected one"};
    constexpr std::int64_t kSecondNs = 1'000'000'000;
    if (auto waited = renderer.wait(kSecondNs); !waited) return waited.error();
  }
}

}  // namespace fanlight
