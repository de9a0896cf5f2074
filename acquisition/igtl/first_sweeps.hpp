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
#include "acquisition/igtl/igtl_image.hpp"
#include "acquisition/igtl/pose_history.hpp"
#include "acquisition/sequence/fan_fit.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "acquisition/source/frame_source.hpp"
#include "proto/base/result.hpp"
#include "proto/igtl/image_body.hpp"

namespace fanlight {

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
  bool sequence_named = false;  ///< the images have a FrameSequence
  bool is_fanlight = false;     ///< it describes its source completely
};

/// Determines from the first images what they are: their geometry, the source of their angles, how long the
/// sweeps are. A Fanlight says all of it with its first image. Otherwise two turning points are waited for,
/// or three volumes by their index. One thread. Allocates.
class FirstSweeps {
 public:
  /// `poses`: of this connection; must outlive this object.
  FirstSweeps(const IgtlAddress& address, std::filesystem::path geometry_path, const PoseHistory& poses);

  /// An image that why_no_frame() accepts. One of another size, or with other pixels, restarts this.
  void add(const IgtlImage& image);

  /// nullopt: more images are needed. With `at_once`: what is known so far, however short the sweeps.
  /// Errors, a sentence each: kUnsupported where the positions form no fan; kBadInput where angles or parts
  /// of the geometry are missing.
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
  Result<LearnedFan> described_fan() const;
  Result<std::optional<LearnedFan>> found(bool at_once) const;
  Result<void> find_angles(LearnedFan& fan, Angles& angles_rad) const;
  struct Candidate {
    std::optional<std::size_t> device;  // of the transforms; absent: the images' own matrices
    std::vector<std::size_t> of;        // the images that have a position
    FanFit fit;
    std::string why_not;  // no fan; empty: it is one
  };
  std::optional<Candidate> candidate(std::optional<std::size_t> device) const;
  std::optional<Candidate> best_candidate() const;
  Result<void> fit(LearnedFan& fan, Angles& angles_rad) const;
  bool agree(const Angles& fitted_rad) const;
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
