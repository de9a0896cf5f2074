// SPDX-License-Identifier: Apache-2.0
// Buffers that shaders read or write by index, as texel buffers or, with FANLIGHT_STORAGE, as storage
// buffers. Which of them is faster differs between drivers, and some have small texel buffers only
// (renderer/vulkan/buffer_access.hpp). `Block` names the storage block. A word is a uint, a pair a vec2.
#ifndef FANLIGHT_SHADERS_BUFFER_ACCESS_H
#define FANLIGHT_SHADERS_BUFFER_ACCESS_H

// clang-format off
#ifdef FANLIGHT_STORAGE
#define FANLIGHT_WORDS_TO_READ(slot, Block, name) layout(binding = slot, scalar) readonly buffer Block { uint name[]; }
#define FANLIGHT_PAIRS_TO_READ(slot, Block, name) layout(binding = slot, scalar) readonly buffer Block { vec2 name[]; }
#define FANLIGHT_WORDS_TO_WRITE(slot, Block, name) layout(binding = slot, scalar) writeonly buffer Block { uint name[]; }
#define fetched(name, index) name[index]
#define fetched_pair(name, index) name[index]
#define store(name, index, word) name[index] = word
#else
#define FANLIGHT_WORDS_TO_READ(slot, Block, name) layout(binding = slot) uniform usamplerBuffer name
#define FANLIGHT_PAIRS_TO_READ(slot, Block, name) layout(binding = slot) uniform samplerBuffer name
#define FANLIGHT_WORDS_TO_WRITE(slot, Block, name) layout(binding = slot, r32ui) writeonly uniform uimageBuffer name
#define fetched(name, index) texelFetch(name, index).x
#define fetched_pair(name, index) texelFetch(name, index).xy
#define store(name, index, word) imageStore(name, index, uvec4(word))
#endif
// clang-format on

#endif
