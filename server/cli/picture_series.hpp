// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "proto/base/file_replacement.hpp"
#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/depth_maps.hpp"
#include "server/codec/h264_coder.hpp"
#include "server/codec/mp4_file.hpp"
#include "server/stream/shared_page.hpp"

namespace fanlight {

/// Names of what is written of one volume; empty: not wanted.
struct RenderFiles {
  std::string picture;  ///< or a video (.mp4), or a page (.html), of all
  std::string depth;
  std::string surface;
  std::string title{};              ///< of a page
  std::filesystem::path beneath{};  ///< as FileAccess::beneath

  FileAccess access() const { return {.beneath = beneath}; }
  bool is_video() const { return picture.ends_with(".mp4"); }
  bool is_page() const { return picture.ends_with(".html"); }
  /// All volumes are in one file.
  bool is_one_file() const { return is_video() || is_page(); }
};

/// kInvalidArgument: an ending that is not known, or a video of odd sides.
Result<void> check_files(const RenderFiles& files, const PictureSize& size);

/// Writes the depth map and the surface, where they are wanted.
Result<void> write_depth_and_surface(const RenderFiles& files, const Picture& picture,
                                     const DepthMaps& depths);

/// x.png, 17 -> x.000017.png
std::string numbered_file(const std::string& path, std::uint64_t number, int digits);

/// Writes the pictures of many volumes: files with their numbers, one video in which each is shown as long as
/// its volume was the newest, or a page with their surfaces.
class PictureSeries {
 public:
  explicit PictureSeries(const RenderFiles& files) : files_(files) {}

  /// `number`: of the volume. `scene`: of the picture.
  Result<void> add(const Picture& picture, std::uint64_t number, std::span<const std::string> notes,
                   const Scene& scene);
  /// The names of the depth map and the surface of that volume.
  RenderFiles numbered(std::uint64_t number) const;
  /// After the last one.
  Result<void> finish();

 private:
  Result<void> add_to_video(const Picture& picture);
  Result<void> add_to_page(const Picture& picture, const Scene& scene);

  const RenderFiles& files_;
  std::unique_ptr<H264Coder> coder_;
  std::optional<Mp4File> video_;
  std::optional<SharedPage> page_;
  std::uint64_t pictures_ = 0;
};

}  // namespace fanlight
