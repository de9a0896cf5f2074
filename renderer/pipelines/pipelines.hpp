// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "renderer/parameters/pipeline_key.hpp"
#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu.hpp"
#include "renderer/vulkan/pipeline_cache.hpp"

namespace fanlight {

/// File name of the shader without its extension ("cast"); names the pipelines in debugging tools.
std::string_view name_of(Shader shader);

/// Where pass 1 samples the volume: a texture, or packed words that are gathered, by a
/// processor or where textures are too small (renderer/volume/frame_preparer.hpp).
enum class Sampling : std::uint8_t { kTexture, kGathering };

/// Builds and caches the compute pipelines of all passes by key. Owns the descriptor set layout and the
/// pipeline layout that all of them share (shaders/bindings.h). Does not know scenes: renderer/parameters
/// turns a scene into keys. Render thread only.
class Pipelines {
 public:
  struct Config {
    Sampling sampling = Sampling::kTexture;
    /// Whether the device runs passes 2 and 3; else it runs no more of them than their temporal filter.
    bool lights = true;
    PipelineCache::Config cache;
  };
  /// Builds the pipelines without constants, temporal_variants() and light_variants(), of those that the
  /// device runs. Other pipelines are built when first requested, and kept. Error: a pipeline that cannot be
  /// built.
  static Result<std::unique_ptr<Pipelines>> create(const Gpu& gpu, const Config& config);

  Sampling sampling() const { return sampling_; }
  /// Config::lights.
  bool lights() const { return lights_; }

  VkDescriptorSetLayout set_layout() const { return set_layout_.get(); }
  VkPipelineLayout layout() const { return layout_.get(); }

  /// Bytes of push constants that a shader may have.
  static constexpr std::uint32_t kPushBytes = 32;

  /// The pipeline of a key. The first call for a key builds the pipeline: it blocks and allocates. Error: a
  /// pipeline that cannot be built.
  Result<VkPipeline> get(const PipelineKey& key);

  /// Null for an absent key.
  Result<VkPipeline> get(const std::optional<PipelineKey>& key);

  /// Saves the driver's cache in its file; see PipelineCache::save().
  void save_cache() { cache_.save(); }

  /// A shader without constants that create() has built.
  VkPipeline fixed(Shader shader) const { return pipelines_.at({.shader = shader}).get(); }

 private:
  Pipelines(const Gpu& gpu, const Config& config)
      : gpu_(gpu), sampling_(config.sampling), lights_(config.lights), cache_(gpu, config.cache) {}
  bool runs(Shader shader) const { return lights_ || shader <= Shader::kTemporal; }
  std::span<const std::uint32_t> spirv_of(Shader shader) const;
  Result<void> create_layouts();
  Result<PipelineHandle> build(const PipelineKey& key) const;

  const Gpu& gpu_;
  Sampling sampling_;
  bool lights_;
  PipelineCache cache_;
  SamplerHandle sampler_;  // must live as long as the set layout that it is part of
  DescriptorSetLayoutHandle set_layout_;
  PipelineLayoutHandle layout_;
  std::map<PipelineKey, PipelineHandle> pipelines_;
};

/// A device with the pipelines that were built for it. Both outlive their users.
struct PassDevice {
  const Gpu* gpu = nullptr;
  Pipelines* pipelines = nullptr;
};

}  // namespace fanlight
