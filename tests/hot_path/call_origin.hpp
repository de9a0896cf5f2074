#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fanlight::test {

/// Whose call it is.
enum class Origin : std::uint8_t { kOurs, kDriver };

/// Walks the stack outwards from the function that `caller`, a return address, lies in. A frame in this
/// program makes the call ours, one in the graphics driver (the driver itself, the Vulkan loader, its layers,
/// LLVM) makes it the driver's, whichever comes first. Frames of any other library belong to whoever called
/// it, so that a std::string of ours is ours and one of LLVM's is not. A stack that ends without either is
/// ours. A function that ends by jumping into the next one leaves no frame: a driver's that ends by jumping
/// into free() is taken for ours, which errs towards the alarm. Neither allocates nor locks.
Origin origin_of(const void* caller);

/// The same stack for a person, innermost first: functions' names where they are known, else the file and
/// the offset that addr2line takes.
std::vector<std::string> stack_from(const void* caller);

}  // namespace fanlight::test
