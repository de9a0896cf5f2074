// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "proto/base/thread_owner.hpp"
#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/speckle_filter.hpp"
#include "renderer/pipelines/pipelines.hpp"
#include "renderer/volume/frame_preparer.hpp"
#include "renderer/volume/render_workers.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The frames of one volume on the GPU. Frames are staged as they arrive, prepared by pass 0, and copied to
/// where rays sample them, with the minima and maxima of their grey levels, by which rays skip empty space.
/// Pass 0 runs on the GPU; with Sampling::kGathering, which is for processors and for volumes
/// larger than a GPU's textures, in FramePreparer.
/// Frames are indexed by ascending angle. Frames that were staged at the wrong index, or dropped by the
/// queue, are detected by their commit number when the whole volume is loaded, and staged then; the others
/// are not copied again.
///
/// Owns the buffers and the texture of the frames. Render thread only.
///
/// Life: load(volume), or stage() of single frames -> begin(options) -> record_piece() or prepare_piece()
/// until done(); again from begin(), for other options, or from load() or stage().
class FrameStore {
 public:
  struct Config {
    std::uint32_t columns = 0;  ///< of a frame
    std::uint32_t rows = 0;
    std::uint32_t frame_capacity = 0;
    bool zero_is_unscanned = false;   ///< as FanGeometry's
    std::uint64_t piece_samples = 0;  ///< approximate work of one piece, in samples of pass 1
    Sampling sampling = Sampling::kTexture;
    /// They prepare the frames with Sampling::kGathering, and must then outlive the store. Else not used.
    RenderWorkers* workers = nullptr;
  };

  FrameStore() = default;
  /// A store without a volume and without memory.
  explicit FrameStore(const PassDevice& device) : device_(device) {}
  /// Allocates all memory except pass 0's. Errors: kUnsupported where such volumes exceed the GPU's limits,
  /// kUnavailable where the GPU has no memory for them.
  static Result<FrameStore> create(const PassDevice& device, const Config& config);

  /// Whether the memory has room for the volume, and for no larger frames, and zeros mean the same. Physical
  /// sizes do not matter.
  bool suits(const Volume& volume) const {
    return suits(volume.geometry()) && volume.stamp().frames <= config_.frame_capacity;
  }
  bool suits(const FanGeometry& geometry) const {
    return geometry.columns == config_.columns && geometry.rows == config_.rows &&
           geometry.zero_is_unscanned == config_.zero_is_unscanned;
  }
  std::uint32_t frame_capacity() const { return config_.frame_capacity; }

  /// Copies those frames that are not staged yet to memory that the GPU reads. Precondition: suits(volume),
  /// and nothing that was recorded is outstanding.
  void load(const Volume& volume);

  /// Copies one frame of a volume that has `frames` frames, not necessarily the last volume. Precondition as
  /// load().
  void stage(std::uint32_t frame_index, std::uint32_t frames, std::uint64_t commit_number,
             std::span<const std::uint8_t> pixels);

  /// Sets pass 0 up. Where the GPU has no memory for the filter, the filter is left out. With the options of
  /// the last call, prepared frames stay prepared. Precondition as load(). Error: a pipeline that cannot be
  /// built.
  Result<void> begin(const Scene::Speckle& options);
  bool filter_left_out() const { return left_out_; }

  /// Whether all frames are prepared with the options of the last begin() and can be sampled.
  bool done() const { return !next_piece(); }
  /// Whether a frame can be prepared before its neighbours are staged.
  bool prepares_single_frames() const {
    return wanted_.filter == SpeckleFilter::kNone || wanted_.across == 1;
  }

  /// Whether this frame is staged at that index.
  bool holds(std::uint32_t frame_index, std::uint64_t commit_number) const {
    return commit_number != 0 && commit_numbers_[frame_index] == commit_number;
  }
  /// Distance, in frames, over which pass 0 mixes frames.
  std::uint32_t reach_frames() const { return speckle_reach_frames(wanted_); }

  /// Whether the processor runs pass 0, by prepare_piece(); else the GPU does, by record_piece().
  bool is_prepared_here() const { return config_.sampling == Sampling::kGathering; }
  /// Runs pass 0 for the next piece, some frames. Precondition: !done(), is_prepared_here(), and nothing that
  /// samples the frames is outstanding.
  void prepare_piece();
  /// The words that rays gather (shaders/fan_volume.h). Precondition: is_prepared_here().
  const std::uint32_t* packed_columns() const { return &packed_.mapped_as<std::uint32_t>(); }
  /// The bounds by which rays skip empty space (shaders/neighbour_min_max.comp). Precondition as above.
  const std::uint32_t* neighbour_min_max() const { return &bounds_.mapped_as<std::uint32_t>(); }
  /// Records pass 0 for the next piece. Precondition: !done(), !is_prepared_here(), and the descriptors of
  /// the pass are bound.
  void record_piece(VkCommandBuffer commands);

  /// Null with Sampling::kGathering.
  const GpuImage& texture() const { return texture_; }

  /// Buffers for the descriptors of FANLIGHT_BINDING_...; nullptr for a buffer that does not exist. The last
  /// begin() or a new store may have replaced them; bindings_changed() says so about begin().
  using Bindings = std::array<std::pair<std::uint32_t, const GpuBuffer*>, 9>;
  Bindings bindings() const;
  bool bindings_changed() const { return bindings_changed_; }

 private:
  // Pass 0 reads four pixels at once, so rows of the staged frames are padded to whole words.
  static constexpr std::uint32_t kPixelsInWord = 4;
  struct Piece {
    std::uint32_t first = 0;
    std::uint32_t end = 0;
  };
  std::uint32_t words_in_row() const { return (config_.columns + kPixelsInWord - 1) / kPixelsInWord; }
  std::uint64_t frame_bytes() const { return std::uint64_t{kPixelsInWord} * words_in_row() * config_.rows; }
  // Of a frame.
  std::uint64_t packed_words() const;
  std::uint64_t bounds_words() const;
  bool filters() const { return wanted_.filter != SpeckleFilter::kNone; }
  std::uint64_t frames_at_a_time(const Scene::Speckle& options) const;
  double samples_of_pixel() const;
  std::uint32_t piece_frames() const;
  std::optional<Piece> next_piece() const;
  void set_frame_count(std::uint32_t frames);
  void copy_frame(std::uint32_t frame_index, std::uint64_t commit_number,
                  std::span<const std::uint8_t> pixels);
  Result<void> create_volume();
  Result<void> create_min_max();
  Result<void> create_filter_memory(const Scene::Speckle& options);
  Result<void> find_pipelines();
  void record_filter(VkCommandBuffer commands, Piece piece);
  void record_copies(VkCommandBuffer commands, Piece piece);

  PassDevice device_;
  Config config_;
  std::uint32_t frames_ = 0;
  Scene::Speckle wanted_;
  Scene::Speckle refused_;  // options of the filter that was left out
  bool left_out_ = false;
  bool bindings_changed_ = false;
  std::uint32_t piece_frames_ = 0;
  std::array<VkPipeline, 2> pipelines_{};  // of the filter; the guided filter has two
  // By frame index: commit number of the staged frame, 0 where it has none; and whether the frame is prepared
  // with the wanted options.
  std::vector<std::uint64_t> commit_numbers_;
  std::vector<bool> prepared_;

  GpuBuffer staged_;
  GpuBuffer coefficients_;  // this and the next are allocated when the GPU is first to filter
  GpuBuffer filtered_;
  GpuBuffer blocks_;  // where the GPU finds the bounds
  GpuBuffer bounds_;
  std::vector<FramePreparer> preparers_;  // for each worker
  GpuBuffer packed_;                      // this or the texture, by Sampling
  GpuImage texture_;
  bool texture_written_ = false;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
