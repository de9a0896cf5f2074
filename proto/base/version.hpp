// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace fanlight {

/// "0.1.0", or or what git says of a commit without a tag (deploy/version.cmake).
const char* version();

}  // namespace fanlight
