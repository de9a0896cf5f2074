// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"
#include "server/codec/surface_coder.hpp"

namespace fanlight {

/// One HTML file that shows surfaces without a server: share.html of the page, with the surfaces in it. Says
/// nothing of the source but the title. One thread.
class SharedPage {
 public:
  /// A file holds no more: mail servers take some 10 MB, and readers wait.
  static constexpr std::size_t kMostBytes = 3'000'000;

  /// `page`: share.html of the page, which must outlive this object. `title`: shown above the picture.
  /// `scene`: lights it; its camera is the first view.
  SharedPage(std::string_view page, const std::string& title, const Scene& scene);

  /// Adds the surface of a picture, that of the next volume of a film. Errors, kInvalidArgument: the picture
  /// shows more than a surface, or none; more than kMostBytes.
  Result<void> add(const Picture& picture);

  /// The same, reduced to the usual size where the picture is more than twice as large: the file would be too
  /// large.
  Result<void> add_within(const Picture& picture, PictureSize usual);

  /// The file.
  std::string html() const;

 private:
  std::string_view page_;
  v1::SharedSurfaces surfaces_;
  SurfaceCoder coder_;
  std::size_t bytes_ = 0;  // of the file, about
  std::int64_t first_capture_ns_ = 0;
};

}  // namespace fanlight
