// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace fanlight {

/// Makes protobuf build the descriptors, prototypes and JSON types of all messages now. It would build each
/// on its first use, and where memory runs out there (an exception within std::call_once), the next use
/// crashes. Call it before a server listens. Throws std::bad_alloc.
void build_protobuf_tables();

}  // namespace fanlight
