# SPDX-License-Identifier: Apache-2.0
# Writes a C++ file OUTPUT that defines the words of the SPIR-V module INPUT as a span named NAME.
file(READ ${INPUT} bytes HEX)
# The file is little endian: the bytes of each word are reversed.
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${bytes}")
file(WRITE ${OUTPUT} "#include \"shaders/spirv.hpp\"

namespace fanlight::shaders {
namespace {
constexpr std::uint32_t kWords[] = {${words}};
}
const std::span<const std::uint32_t> ${NAME}(kWords);
}  // namespace fanlight::shaders
")
