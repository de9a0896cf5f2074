// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/shader_interface.hpp"

#include <algorithm>
#include <unordered_map>

#include "shaders/spirv.hpp"

namespace fanlight {

namespace {

// Of the SPIR-V specification.
constexpr std::size_t kHeaderWords = 5;
constexpr std::uint32_t kOpTypeImage = 25;
constexpr std::uint32_t kOpTypeSampledImage = 27;
constexpr std::uint32_t kOpTypePointer = 32;
constexpr std::uint32_t kOpVariable = 59;
constexpr std::uint32_t kOpDecorate = 71;
constexpr std::uint32_t kBinding = 33;
constexpr std::uint32_t kUniform = 2;
constexpr std::uint32_t kStorageBuffer = 12;
constexpr std::uint32_t kDimBuffer = 5;
constexpr std::uint32_t kWrittenImage = 2;  // "Sampled" of an image that is used without a sampler

VkDescriptorType type_of_image(std::uint32_t dimension, std::uint32_t sampled) {
  if (dimension != kDimBuffer) return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  return sampled == kWrittenImage ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER
                                  : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
}

BindingTypes all_bindings(BufferAccess access) {
  BindingTypes all;
  for (const shaders::Pass& pass : shaders::passes()) {
    const bool texels = access == BufferAccess::kTexels;
    for (const auto spirv :
         {texels ? pass.texels : pass.storage, texels ? pass.gathering_texels : pass.gathering_storage}) {
      const BindingTypes types = bindings_of(spirv);
      all.resize(std::max(all.size(), types.size()));
      for (std::size_t binding = 0; binding < types.size(); ++binding) {
        if (types[binding]) all[binding] = types[binding];
      }
    }
  }
  return all;
}

}  // namespace

BindingTypes bindings_of(std::span<const std::uint32_t> spirv) {
  std::unordered_map<std::uint32_t, std::uint32_t> bindings;        // of variables
  std::unordered_map<std::uint32_t, std::uint32_t> pointees;        // of pointer types
  std::unordered_map<std::uint32_t, VkDescriptorType> image_types;  // of images, with or without a sampler
  BindingTypes types;
  // Decorations come before types, and types before the variables that use them.
  for (std::size_t at = kHeaderWords; at < spirv.size(); at += std::max(spirv[at] >> 16U, 1U)) {
    const auto operation = spirv[at] & 0xFFFFU;
    const auto word = [&](std::size_t index) { return spirv[at + index]; };
    if (operation == kOpDecorate && word(2) == kBinding) bindings[word(1)] = word(3);
    if (operation == kOpTypeImage) image_types[word(1)] = type_of_image(word(3), word(7));
    if (operation == kOpTypeSampledImage) image_types[word(1)] = image_types.at(word(2));
    if (operation == kOpTypePointer) pointees[word(1)] = word(3);
    if (operation != kOpVariable || !bindings.contains(word(2))) continue;
    const std::uint32_t binding = bindings.at(word(2));
    const std::uint32_t storage_class = word(3);
    if (types.size() <= binding) types.resize(binding + 1);
    types[binding] = storage_class == kUniform         ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
                     : storage_class == kStorageBuffer ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
                                                       : image_types.at(pointees.at(word(1)));
  }
  return types;
}

const BindingTypes& binding_types(BufferAccess access) {
  static const BindingTypes kTexels = all_bindings(BufferAccess::kTexels);
  static const BindingTypes kStorage = all_bindings(BufferAccess::kStorage);
  return access == BufferAccess::kTexels ? kTexels : kStorage;
}

std::uint32_t storage_buffers(BufferAccess access) {
  return static_cast<std::uint32_t>(
      std::ranges::count(binding_types(access), std::optional(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER)));
}

}  // namespace fanlight
