// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/renderer.hpp"

namespace fanlight {

/// The picture of one volume. Blocks until it is finished. Errors: those of Renderer::load(), which say why
/// the GPU refuses the volume, and of Renderer::advance() and wait().
Result<Picture> render_once(Renderer& renderer, const Volume& volume);

}  // namespace fanlight
