#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "proto/fan_geometry.hpp"
#include "proto/scene.hpp"
#include "renderer/device_handle.hpp"
#include "renderer/gpu.hpp"

namespace fanlight {

/// The shaders, in the order in which they run.
enum class Shader : std::uint8_t {
  kBox,  // pass 0
  kMedian,
  kGuide,
  kGuided,
  kBlocks,
  kBounds,
  kPack,
  kSegments,  // pass 1
  kChanged,
  kCast,
  kSlice,
  kSteady,  // pass 2
  kTiles,
  kUneven,
  kIslands,
  kConfidence,
  kHoles,
  kMeanRows,
  kMeanColumns,
  kSmooth,
  kNearest,
  kLight,
  kDiffuse,  // pass 3
  kFinish
};

/// Whether pass 1 passes over what can hold no surface; the pictures are the same. Off to compare.
enum class Skipping : std::uint8_t { kOn, kOff };

/// Where pass 1 samples the volume: a texture, or words that a processor gathers (shaders/pack.comp).
enum class Sampling : std::uint8_t { kTexture, kGathering };

/// The compute pipelines of all passes and the one descriptor set layout that they share
/// (shaders/bindings.h). Render thread only.
///
/// A pipeline is a shader with the options that are constants to it. Those of passes 2 and 3 are built when
/// this is made, but for the confidence, the others when first asked for, and kept.
class Passes {
 public:
  static Result<std::unique_ptr<Passes>> create(const Gpu& gpu, Sampling sampling);

  static VkDescriptorType descriptor_type(std::uint32_t binding);

  Sampling sampling() const { return sampling_; }

  VkDescriptorSetLayout set_layout() const { return set_layout_.get(); }
  VkPipelineLayout layout() const { return layout_.get(); }

  /// Bytes of push constants that a shader may have.
  static constexpr std::uint32_t kPushBytes = 32;

  /// Pass 0's filter, with a window of size x size pixels and `across` frames; kGuided has two halves.
  Result<VkPipeline> speckle(Shader shader, const Scene::Speckle& options);

  /// Pass 1 for what a scene asks of it, and for frames of that kind: the rays, and the pass before them that
  /// tells them what to pass over, where anything can be: null for modes that keep all of a ray.
  /// `tiles`: FANLIGHT_CAST_...
  Result<VkPipeline> cast(const Scene& scene, FrameKind kind, Skipping skipping, int tiles);
  Result<VkPipeline> segments(const Scene& scene, FrameKind kind, Skipping skipping);
  Result<VkPipeline> slice(FrameKind kind);

  /// Which tiles to cast again where frames were replaced.
  Result<VkPipeline> changed(const Scene& scene);

  /// What pass 2's filter weighs pixels by.
  Result<VkPipeline> confidence(const Scene& scene, FrameKind kind);

  /// One half of pass 2's Gaussian or edge-preserving filter.
  enum class Axis : std::uint8_t { kRows, kColumns };
  Result<VkPipeline> smooth(Axis axis, DepthFilter kind);

  /// Pass 2's light.
  Result<VkPipeline> light(const Scene& scene);

  /// A shader without options.
  VkPipeline fixed(Shader shader) const { return pipelines_.at({shader, {}}).get(); }

 private:
  /// Values of the specialisation constants 0, 1, ... of a shader.
  using Constants = std::array<std::int32_t, 8>;

  Passes(const Gpu& gpu, Sampling sampling) : gpu_(gpu), sampling_(sampling) {}
  std::span<const std::uint32_t> spirv_of(Shader shader) const;
  Result<void> create_layouts();
  Result<VkPipeline> pipeline(Shader shader, const Constants& constants);
  Result<PipelineHandle> build(Shader shader, const Constants& constants);

  const Gpu& gpu_;
  Sampling sampling_;
  SamplerHandle sampler_;  // part of the set layout for as long as that lives
  DescriptorSetLayoutHandle set_layout_;
  PipelineLayoutHandle layout_;
  std::map<std::pair<Shader, Constants>, PipelineHandle> pipelines_;
};

}  // namespace fanlight
