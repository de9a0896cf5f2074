# Writes the words of the SPIR-V module INPUT as a C++ span named NAME to OUTPUT.
file(READ ${INPUT} bytes HEX)
# SPIR-V is little endian here: the four bytes of a word turn round.
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${bytes}")
file(WRITE ${OUTPUT} "#include \"shaders/spirv.hpp\"

namespace fanlight::shaders {
namespace {
constexpr std::uint32_t kWords[] = {${words}};
}
const std::span<const std::uint32_t> ${NAME}(kWords);
}  // namespace fanlight::shaders
")
