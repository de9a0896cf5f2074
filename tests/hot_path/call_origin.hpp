// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fanlight::test {

/// The code that is responsible for a call.
enum class Origin : std::uint8_t { kOurs, kDriver };

/// Finds the origin of a call by unwinding the stack from the function that contains `caller`, a return
/// address. The first frame in this program gives kOurs, the first frame in the graphics driver (the driver,
/// the Vulkan loader, its layers, LLVM) gives kDriver. Frames of other libraries are skipped: a std::string
/// belongs to the code that uses it. A stack without either gives kOurs. A tail call leaves no frame, so a
/// driver function that ends with a tail call of free() is reported as kOurs: a false alarm, not a missed
/// call. Does not allocate or lock.
Origin origin_of(const void* caller);

/// The same stack as text, innermost frame first: the name of each function, if known, and the file and the
/// offset for addr2line.
std::vector<std::string> stack_from(const void* caller);

}  // namespace fanlight::test
