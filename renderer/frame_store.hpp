#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "proto/scene.hpp"
#include "proto/volume.hpp"
#include "renderer/gpu_memory.hpp"
#include "renderer/passes.hpp"

namespace fanlight {

/// The frames of one volume on their way to pass 1: staged as they came, through pass 0, to where rays sample
/// them, and with the bounds of their grey levels by which rays pass over what can hold nothing. Each frame
/// has a place, by ascending angle; a frame that is there already, known by its arrival number, is not taken
/// again, so that what came ahead of its volume costs nothing when that is whole. Render thread only.
///
/// Life: load(volume), or stage() of single frames -> begin(options) -> record_piece() until done(); again
/// from begin(), for other options, or from load() or stage().
class FrameStore {
 public:
  struct Config {
    std::uint32_t columns = 0;  ///< of a frame
    std::uint32_t rows = 0;
    std::uint32_t frame_capacity = 0;
    std::uint64_t piece_samples = 0;  ///< about the work of one piece, in samples of pass 1
    Sampling sampling = Sampling::kTexture;
  };

  /// A store that holds no volume and no memory.
  FrameStore() = default;
  /// Allocates all memory but pass 0's. Errors: kUnsupported where such volumes are beyond the GPU's limits,
  /// kUnavailable where it has no memory for them.
  static Result<FrameStore> create(const Gpu& gpu, const Config& config);

  /// Whether it has room for the volume, and for no larger frames; millimetres do not matter.
  bool suits(const Volume& volume) const {
    return suits(volume.geometry()) && volume.stamp().frames <= config_.frame_capacity;
  }
  bool suits(const FanGeometry& geometry) const {
    return geometry.columns == config_.columns && geometry.rows == config_.rows;
  }
  std::uint32_t frame_capacity() const { return config_.frame_capacity; }

  /// Copies the frames that are not there yet, in ascending order of angle, to where the GPU can fetch them.
  /// Precondition: it suits them, and nothing that was recorded is outstanding.
  void load(const Volume& volume);

  /// Puts one frame in its place of `frames`, which may be others than those of the last volume. Precondition
  /// as load().
  void stage(std::uint32_t place, std::uint32_t frames, std::uint64_t arrival,
             std::span<const std::uint8_t> pixels);

  /// Sets pass 0 up. Where there is no memory for the filter, it is left out. Options that are those of the
  /// last call go on where that is. Precondition as load(). Error: a pipeline that cannot be built.
  Result<void> begin(const Gpu& gpu, Passes& passes, const Scene::Speckle& options);
  bool filter_left_out() const { return left_out_; }

  /// Whether all frames are where rays sample them, as the last begin() wants them.
  bool done() const { return !next_piece(); }
  /// Whether a frame can be prepared before its neighbours are there.
  bool prepares_single_frames() const {
    return wanted_.filter == SpeckleFilter::kNone || wanted_.across == 1;
  }

  /// Whether that frame is the one in a place.
  bool holds(std::uint32_t place, std::uint64_t arrival) const {
    return arrival != 0 && arrivals_[place] == arrival;
  }
  /// How many frames away pass 0 still mixes into a frame: the guided filter takes a mean of means.
  std::uint32_t reach_across() const {
    const auto radius = static_cast<std::uint32_t>(wanted_.across) / 2;
    return wanted_.filter == SpeckleFilter::kNone     ? 0
           : wanted_.filter == SpeckleFilter::kGuided ? 2 * radius
                                                      : radius;
  }

  /// Records pass 0 for the next piece, some frames. The slot's descriptors are bound. Precondition: !done().
  void record_piece(VkCommandBuffer commands, const Passes& passes);

  /// Null where rays gather words.
  const GpuImage& texture() const { return texture_; }

  /// Buffers for the descriptors of FANLIGHT_BINDING_..., nullptr for one that nothing uses. They are others
  /// where the last begin() says so.
  using Bindings = std::array<std::pair<std::uint32_t, const GpuBuffer*>, 10>;
  Bindings bindings() const;
  bool bindings_changed() const { return bindings_changed_; }

 private:
  // Pass 0 reads four pixels at once, so that rows of the staged frames are padded to whole words.
  static constexpr std::uint32_t kPixelsInWord = 4;
  struct Piece {
    std::uint32_t first = 0;
    std::uint32_t end = 0;
  };
  std::uint32_t words_in_row() const { return (config_.columns + kPixelsInWord - 1) / kPixelsInWord; }
  std::uint64_t frame_bytes() const { return std::uint64_t{kPixelsInWord} * words_in_row() * config_.rows; }
  bool filters() const { return wanted_.filter != SpeckleFilter::kNone; }
  std::uint64_t frames_at_a_time(const Gpu& gpu, const Scene::Speckle& options) const;
  std::uint32_t piece_frames(const Gpu& gpu) const;
  std::optional<Piece> next_piece() const;
  void hold(std::uint32_t frames);
  void put(std::uint32_t place, std::uint64_t arrival, std::span<const std::uint8_t> pixels);
  Result<void> create_volume(const Gpu& gpu);
  Result<void> create_filter_memory(const Gpu& gpu, const Scene::Speckle& options);
  Result<void> find_pipelines(Passes& passes);
  void record_filter(VkCommandBuffer commands, const Passes& passes, Piece piece);
  void record_copies(VkCommandBuffer commands, const Passes& passes, Piece piece);

  Config config_;
  std::uint32_t frames_ = 0;
  Scene::Speckle wanted_;
  Scene::Speckle refused_;  // what was left out, where anything was
  bool left_out_ = false;
  bool bindings_changed_ = false;
  std::uint32_t piece_frames_ = 0;
  std::array<VkPipeline, 2> pipelines_{};  // the first and, for a guided filter, second half
  // By place: which frame is staged there, 0 where it has no number; and whether rays sample it as is wanted.
  std::vector<std::uint64_t> arrivals_;
  std::vector<bool> prepared_;

  GpuBuffer staged_;
  GpuBuffer coefficients_;  // this and the next: only where pass 0 was ever asked for
  GpuBuffer filtered_;
  GpuBuffer blocks_;
  GpuBuffer bounds_;
  GpuBuffer packed_;  // this or the texture
  GpuImage texture_;
  bool texture_written_ = false;
};

}  // namespace fanlight
