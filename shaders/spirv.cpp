// SPDX-License-Identifier: Apache-2.0
#include "shaders/spirv.hpp"

// The assembler copies each module from its file, NAME.spv in its search path (CMakeLists.txt): to compile
// the words as an array takes longer than to compile the shader.
#define FANLIGHT_EMBED_PLAIN(name)                                                        \
  asm(".pushsection .rodata\n"                                                            \
      ".balign 4\n"                                                                       \
      ".global fanlight_" #name "_begin, fanlight_" #name                                 \
      "_end\n"                                                                            \
      ".hidden fanlight_" #name "_begin, fanlight_" #name                                 \
      "_end\n"                                                                            \
      "fanlight_" #name "_begin: .incbin \"" #name                                        \
      ".spv\"\n"                                                                          \
      "fanlight_" #name                                                                   \
      "_end:\n"                                                                           \
      ".popsection");                                                                     \
  extern "C" [[gnu::visibility("hidden")]] const std::uint32_t fanlight_##name##_begin[]; \
  extern "C" [[gnu::visibility("hidden")]] const std::uint32_t fanlight_##name##_end[];   \
  const Words name##_spirv(fanlight_##name##_begin, fanlight_##name##_end);
#define FANLIGHT_EMBED_INDEXING(name) \
  FANLIGHT_EMBED_PLAIN(name)          \
  FANLIGHT_EMBED_PLAIN(name##_storage)
#define FANLIGHT_EMBED_SAMPLING(name) \
  FANLIGHT_EMBED_INDEXING(name)       \
  FANLIGHT_EMBED_INDEXING(name##_gathering)
#define FANLIGHT_PASS(name, enumerator, variants, pipelines) FANLIGHT_EMBED_##variants(name)

namespace fanlight::shaders {

#include "shaders/passes.inc"
FANLIGHT_EMBED_INDEXING(access_trial)

}  // namespace fanlight::shaders
