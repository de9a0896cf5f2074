#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "proto/scene.hpp"
#include "proto/volume.hpp"
#include "renderer/gpu_memory.hpp"
#include "renderer/passes.hpp"

namespace fanlight {

/// The frames of one volume on their way to pass 1: staged as they came, through pass 0, into the texture
/// that rays sample. Render thread only.
///
/// Life: load(volume) -> begin(options) -> record_filter() until at_last_piece() was recorded ->
/// record_upload() -> done(), and again from begin(), for other options, or load().
class FrameStore {
 public:
  struct Config {
    std::uint32_t columns = 0;  ///< of a frame
    std::uint32_t rows = 0;
    std::uint32_t frame_capacity = 0;
    std::uint64_t piece_samples = 0;  ///< about the work of one piece, in samples of pass 1
  };

  /// A store that holds no volume and no memory.
  FrameStore() = default;
  /// Allocates all memory but pass 0's. Errors: kUnsupported where such volumes are beyond the GPU's limits,
  /// kUnavailable where it has no memory for them.
  static Result<FrameStore> create(const Gpu& gpu, const Config& config);

  /// Whether it has room for the volume, and for no larger frames; millimetres do not matter.
  bool suits(const Volume& volume) const {
    return volume.geometry().columns == config_.columns && volume.geometry().rows == config_.rows &&
           volume.stamp().frames <= config_.frame_capacity;
  }
  std::uint32_t frame_capacity() const { return config_.frame_capacity; }

  /// Copies the frames, in ascending order of angle, to where the GPU can fetch them. Precondition: it suits
  /// them, and nothing that was recorded is outstanding.
  void load(const Volume& volume);

  /// Sets pass 0 up. Where the volume exceeds what a shader of this GPU can address in one buffer, or there
  /// is no memory for it, the filter is left out. Options that are those of the last call go on where that
  /// is. Precondition as load(). Error: a pipeline that cannot be built.
  Result<void> begin(const Gpu& gpu, Passes& passes, const Scene::Speckle& options);
  bool filter_left_out() const { return left_out_; }

  /// Whether the texture holds the volume as the last begin() wants it.
  bool done() const { return prepared_ == wanted_; }
  /// Whether the next piece is the first, or the last, after which the upload is due.
  bool at_first_piece() const { return next_frame_ == 0; }
  bool at_last_piece() const { return wanted_.filter == SpeckleFilter::kNone || piece_end() == frames_; }
  bool filters() const { return wanted_.filter != SpeckleFilter::kNone; }

  /// Records the next piece of pass 0, some frames; nothing where there is no filter. The slot's descriptors
  /// are bound.
  void record_filter(VkCommandBuffer commands, const Passes& passes);
  /// Records the upload into the texture. Precondition: every piece was recorded.
  void record_upload(VkCommandBuffer commands);

  const GpuImage& texture() const { return texture_; }

  /// Buffers for the descriptors of FANLIGHT_BINDING_..., nullptr for one that nothing uses. They are others
  /// where the last begin() took memory.
  using Bindings = std::array<std::pair<std::uint32_t, const GpuBuffer*>, 3>;
  Bindings bindings() const;
  bool took_memory() const { return took_memory_; }

 private:
  // Pass 0 reads four pixels at once, so that rows of the staged frames are padded to whole words.
  static constexpr std::uint32_t kPixelsInWord = 4;
  std::uint32_t words_in_row() const { return (config_.columns + kPixelsInWord - 1) / kPixelsInWord; }
  std::uint64_t frame_bytes() const { return std::uint64_t{kPixelsInWord} * words_in_row() * config_.rows; }
  bool fits(const Gpu& gpu, const Scene::Speckle& options) const;
  std::uint64_t frames_at_a_time(const Gpu& gpu, const Scene::Speckle& options) const;
  std::uint32_t piece_frames(const Gpu& gpu) const;
  std::uint32_t piece_end() const { return std::min(next_frame_ + piece_frames_, frames_); }
  Result<void> create_memory(const Gpu& gpu, const Scene::Speckle& options);
  Result<void> find_pipelines(Passes& passes);

  Config config_;
  std::uint32_t frames_ = 0;
  Scene::Speckle wanted_;
  std::optional<Scene::Speckle> prepared_;  // how the frames in the texture were prepared
  bool left_out_ = false;
  bool took_memory_ = false;
  std::uint32_t next_frame_ = 0;  // the first that pass 0 has yet to filter
  std::uint32_t piece_frames_ = 0;
  std::array<VkPipeline, 2> pipelines_{};  // the first and, for a guided filter, second half

  GpuBuffer staged_;
  GpuBuffer coefficients_;  // this and the next: only where pass 0 was ever asked for
  GpuBuffer filtered_;
  GpuImage texture_;
};

}  // namespace fanlight
