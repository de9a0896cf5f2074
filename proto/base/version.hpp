// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace fanlight {

/// "0.1.0", or "0.1.0+12.gabcdef" for 12 commits after that release (deploy/version.cmake).
const char* version();

}  // namespace fanlight
