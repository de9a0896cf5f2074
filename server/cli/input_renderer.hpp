// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/offline_volumes.hpp"
#include "renderer/renderer.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/cli/render_options.hpp"
#include "server/cli/render_report.hpp"

namespace fanlight {

/// kInvalidArgument: options that contradict one another, or name files that cannot be written. Before work
/// is done that would be lost.
Result<void> check_render(const RenderOptions& options);

/// Renders volumes of one input, one after the other, and writes their files. One thread.
class InputRenderer {
 public:
  /// All given must outlive it. The device is opened where it is not yet. With a store, pipelines are taken
  /// from there and kept there. Errors: those of check_render(), open_source(), open_device() and
  /// Renderer::create().
  static Result<std::unique_ptr<InputRenderer>> create(const RenderOptions& options, RenderDevice& device,
                                                       PipelineStore* store = nullptr);

  InputRenderer(const InputRenderer&) = delete;
  InputRenderer& operator=(const InputRenderer&) = delete;

  /// Renders the next volume and writes its files, with its number in their names where `options.all`. False:
  /// the source has ended, or options.count volumes are done.
  Result<bool> next();
  /// The volume of options.volume, or the first one.
  Result<void> pick();
  /// After the last one.
  Result<void> finish() { return series_.finish(); }

  /// Of the volume rendered last; valid until the next one.
  const Picture& picture() const { return picture_; }
  Result<RenderReport> report() const;

  std::uint64_t pictures() const { return pictures_; }
  std::uint64_t interpolated() const {
    return interpolated_;
  }                                                        ///< of them, of volumes with interpolated frames
  const WarnedVolumes& warned() const { return warned_; }  ///< of them, by warning
  std::uint64_t expected() const { return expected_; }     ///< volumes; 0: not known
  /// What is assumed of the source, and what was chosen.
  const std::vector<std::string>& notes() const { return notes_; }
  const std::vector<DroppedSweep>& dropped() { return volumes_->dropped(); }
  const AcquisitionCounters& counters() const { return volumes_->counters(); }
  /// The files written so far, in their order.
  const std::vector<std::string>& written() const { return written_; }

 private:
  InputRenderer(const RenderOptions& options, const RenderDevice& device)
      : options_(options), device_(device), series_(options.files) {}

  Result<void> render(const Volume& volume);
  Result<void> look_at(const Volume& volume);
  Result<void> write_depth_and_surface_of(const RenderFiles& files);

  const RenderOptions& options_;
  const RenderDevice& device_;
  PictureSeries series_;
  Doorbell bell_;
  ProbeLink probe_{bell_, bell_};
  std::unique_ptr<FrameSource> source_;
  PictureSize size_;
  RenderCounters counters_;
  Scene suggested_;  // for the source alone
  Scene scene_;
  bool finds_view_ = false;  // by the first volume
  std::unique_ptr<Renderer> renderer_;
  std::optional<OfflineVolumes> volumes_;
  std::vector<std::string> notes_;
  std::vector<std::string> written_;
  Picture picture_;
  std::uint64_t pictures_ = 0;
  std::uint64_t interpolated_ = 0;
  WarnedVolumes warned_{};
  std::uint64_t expected_ = 0;
};

}  // namespace fanlight
