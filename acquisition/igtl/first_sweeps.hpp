// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/igtl/frame_notes.hpp"
#include "acquisition/igtl/igtl_address.hpp"
#include "acquisition/igtl/pose_history.hpp"
#include "acquisition/replay/fan_fit.hpp"
#include "acquisition/replay/pixel_values.hpp"
#include "acquisition/source/frame_source.hpp"
#include "proto/base/result.hpp"
#include "proto/igtl/image_body.hpp"

namespace fanlight {

/// An image as it came, with what was said of it.
struct IgtlImage {
  igtl::ImageBody body;
  std::span<const std::uint8_t> pixels;  ///< as stored; of the whole image
  igtl::Metadata metadata;
  FrameNotes notes;
  std::int64_t time_ns = 0;  ///< the sender's, ns since 1970; without one, of its arrival
};

/// How a sender stores its pixels; nullopt: not as 8 or 16 bit whole numbers.
std::optional<PixelFormat> pixel_format(const igtl::ImageBody& image);

/// Why an image is none that a sweep is made of; empty: it is.
std::string why_no_frame(const igtl::ImageBody& image);

/// Columns and rows of the frames that these images become.
FrameSize frame_size(const igtl::ImageBody& image, const ImageOrientation& orientation);

/// The pose of a frame; nullopt where its columns are the rows of the image.
std::optional<ImagePose> frame_pose(const igtl::GridPose& grid, const ImageOrientation& orientation,
                                    FrameSize size);

/// What makes frames of images.
struct LearnedFan {
  enum class Angles : std::uint8_t {
    kNamed,       ///< the metadata of each image has its angle
    kMatrices,    ///< by the images' own matrices
    kTransforms,  ///< by transforms of a device, which place the images' matrices
  };
  SourceDescription source;  ///< but for its name
  Angles angles = Angles::kNamed;
  igtl::DeviceName device;   ///< of the transforms
  FanFit fit;                ///< where angles are not named; without angles_rad
  double centre_column = 0;  ///< of the fit
  ValueWindow window;        ///< of pixels that are no grey levels
  PixelFormat format;
  bool sequence_named = false;  ///< by a Fanlight, which numbers all frames of its source
};

/// Finds out by the first images what they are: their geometry, where their angles are told, how long the
/// sweeps are. A Fanlight says all of it with its first image. Otherwise two turning points are waited for,
/// or three volumes by their index. One thread. Allocates.
class FirstSweeps {
 public:
  /// `poses`: of this connection; must outlive this object.
  FirstSweeps(const IgtlAddress& address, std::filesystem::path geometry_path, const PoseHistory& poses);

  /// An image that why_no_frame() accepts. One of another size, or with other pixels, begins anew.
  void add(const IgtlImage& image);

  /// nullopt: more images are needed. With `at_once`: what they tell so far, however short the sweeps.
  /// Errors, a sentence each: kUnsupported where the positions form no fan; kBadInput where angles or parts
  /// of the geometry are told nowhere.
  Result<std::optional<LearnedFan>> result(bool at_once);

  std::size_t images() const { return seen_.size(); }

 private:
  struct Seen {
    FrameNotes notes;
    igtl::GridPose matrix;
    std::int64_t time_ns = 0;
  };
  using Fields = std::map<std::string, std::string, std::less<>>;

  using Angles = std::vector<std::optional<double>>;  // of the images; absent: not known

  bool is_told() const;
  Result<LearnedFan> told() const;
  Result<std::optional<LearnedFan>> found(bool at_once) const;
  Result<void> find_angles(LearnedFan& fan, Angles& angles_rad) const;
  Result<void> fit(LearnedFan& fan, Angles& angles_rad) const;
  Result<void> add_geometry(LearnedFan& fan) const;
  void add_guesses(Fields& fields, LearnedFan& fan, double column_rows, double row_mm) const;
  FrameSize size() const;

  IgtlAddress address_;
  std::filesystem::path geometry_path_;
  const PoseHistory& poses_;
  std::vector<Seen> seen_;
  igtl::ImageBody first_;
  PixelFormat format_;
  Fields fields_;                         // Fanlight... of the newest image
  std::vector<std::uint8_t> brightest_;   // each pixel's highest grey level, by the whole window
  std::vector<std::uint8_t> grey_;        // of one image
  std::optional<GreyLevels> levels_;      // to the whole window
  std::optional<ValueHistogram> values_;  // where pixels are no grey levels
};

}  // namespace fanlight
