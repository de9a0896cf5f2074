// SPDX-License-Identifier: Apache-2.0
#include "server/cli/picture_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "proto/base/printable.hpp"
#include "server/cli/picture_file.hpp"
#include "server/codec/surface_mesh.hpp"
#include "server/stream/page_files.hpp"

namespace fanlight {

namespace {

constexpr int kDigits = 4;

}  // namespace

Result<void> check_files(const RenderFiles& files, const PictureSize& size) {
  for (const std::string_view video : {".avi", ".webm", ".mov", ".mkv", ".mpg", ".mpeg", ".m4v", ".MP4"}) {
    if (!files.picture.ends_with(video)) continue;
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} is a video that is not written, expected .mp4", printable(files.picture))};
  }
  if (auto named = check_depth_path(files.depth); !named) return named;
  if (auto named = check_mesh_path(files.surface); !named) return named;
  auto named = files.is_one_file() ? check_folder_of(files.picture) : check_picture_path(files.picture);
  if (!named) return named;
  for (const std::string* const path : {&files.depth, &files.surface}) {
    if (auto there = check_folder_of(*path); !there) return there;
  }
  if (!files.is_video() || (size.width % 2 == 0 && size.height % 2 == 0)) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("a video of {} x {} pixels, expected an even width and height", size.width, size.height)};
}

Result<void> write_depth_and_surface(const RenderFiles& files, const Picture& picture,
                                     const DepthMaps& depths) {
  if (!files.depth.empty()) {
    if (auto written = write_depth(files.depth, depths.smooth_mm, picture.width, picture.height,
                                   picture.stamp.view, files.access());
        !written)
      return written;
  }
  if (files.surface.empty()) return {};
  return write_mesh(files.surface, mesh_of(picture), files.access());
}

std::string numbered_file(const std::string& path, std::uint64_t number, int digits) {
  if (path.empty()) return path;
  const std::filesystem::path whole(path);
  return (whole.parent_path() / whole.stem()).string() + fmt::format(".{:0{}}", number, digits) +
         whole.extension().string();
}

RenderFiles PictureSeries::numbered(std::uint64_t number) const {
  return {.picture = numbered_file(files_.picture, number, kDigits),
          .depth = numbered_file(files_.depth, number, kDigits),
          .surface = numbered_file(files_.surface, number, kDigits),
          .beneath = files_.beneath};
}

Result<void> PictureSeries::add(const Picture& picture, std::uint64_t number,
                                std::span<const std::string> notes, const Scene& scene) {
  auto added = files_.is_video()  ? add_to_video(picture)
               : files_.is_page() ? add_to_page(picture, scene)
                                  : write_picture(numbered(number).picture, picture, notes, files_.access());
  ++pictures_;
  return added;
}

Result<void> PictureSeries::add_to_page(const Picture& picture, const Scene& scene) {
  if (!page_) page_.emplace(shared_page_template(), files_.title, scene);
  return page_->add(picture);
}

Result<void> PictureSeries::add_to_video(const Picture& picture) {
  constexpr double kBitsPerPixel = 0.4;  // no blocks show
  constexpr double kUsualHz = 10;
  constexpr std::uint64_t kPicturesPerKey = 30;
  const VolumeStamp& volume = picture.stamp.volume;
  if (!video_) {
    const double sweep_s =
        1e-9 * static_cast<double>(volume.last_capture_time_ns - volume.first_capture_time_ns);
    const double rate_hz = std::clamp(sweep_s > 0 ? 1 / sweep_s : kUsualHz, 1.0, 60.0);
    const double kbps = kBitsPerPixel * picture.width * picture.height * rate_hz / 1000;
    coder_ = std::make_unique<H264Coder>(static_cast<int>(std::max(kbps, 500.0)), rate_hz);
    video_.emplace(files_.picture, picture.width, picture.height, files_.beneath);
  }
  const auto coded = coder_->encode(pixels_of(picture), pictures_ % kPicturesPerKey == 0);
  if (!coded) return coded.error();
  return video_->add(coded->bytes, coded->key, volume.last_capture_time_ns);
}

Result<void> PictureSeries::finish() {
  if (page_) {
    return replace_file(files_.picture, page_->html(), files_.access());
  }
  return video_ ? video_->finish() : Result<void>();
}

}  // namespace fanlight
