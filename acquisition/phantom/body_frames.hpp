// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/phantom/beam_echo.hpp"
#include "acquisition/phantom/body_scene.hpp"
#include "acquisition/phantom/echo_scale.hpp"
#include "acquisition/phantom/frame_speckle.hpp"
#include "acquisition/phantom/scan_converter.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// Draws the frames of a BodyScene: the echoes of each scan line (BeamEcho), blurred a little across the
/// lines and a little of it far across them (side lobes), with reverberation below the face, speckled in the
/// grid of lines and samples, in grey levels, and for a Cartesian frame scan-converted. So speckle is finer
/// near the probe than far from it, as behind a real beam.
///
/// One thread; draw() allocates nothing.
class BodyFrames {
 public:
  struct Config {
    BodyScene::Kind kind = BodyScene::Kind::kFace;
    bool moving = true;
    std::uint64_t seed = 1;     ///< of the speckle, and with BodyScene::Kind::kWomb of the poses
    bool has_near_wall = true;  ///< BodyScene::Kind::kWomb only
    bool has_speckle = true;
    bool has_clutter = true;    ///< side lobes, and reverberation below the probe's face
    double frame_step_rad = 0;  ///< between neighbouring frames
    double beam_mm = 0;         ///< see BeamEcho
    EchoScale scale;
  };

  /// A Cartesian frame is drawn from three lines for eight columns.
  BodyFrames(const Config& config, const FanGeometry& geometry);

  /// Where and when a frame is scanned.
  struct Exposure {
    double time_s = 0;
    double angle_rad = 0;
    FrameSpeckle::Place place;
  };

  /// Writes rows x columns pixels.
  void draw(const Exposure& exposure, std::span<std::uint8_t> pixels);

  const BodyScene& scene() const { return scene_; }

 private:
  /// Of a scan line in the plane of the frame: a point on it, and its direction.
  struct ScanLine {
    double x_mm = 0;
    double depth_mm = 0;
    double sine = 0;
    double cosine = 1;
  };

  BodyScene::Line in_transducer_frame(const ScanLine& line, double angle_rad) const;
  void draw_samples(std::uint32_t sample, std::span<std::uint8_t> greys);
  void blur_across(std::uint32_t sample);

  FanGeometry geometry_;
  EchoScale scale_;
  BodyScene scene_;
  BeamEcho beam_;
  BeamEcho::Samples samples_;
  std::uint32_t samples_in_line_;
  std::uint32_t line_stride_;  // in power_
  std::vector<ScanLine> lines_;
  std::uint32_t lobe_lines_ = 0;      // to either side of a line; 0: no side lobes
  std::vector<float> power_;          // lines x line_stride_
  std::vector<float> reverberation_;  // power of each sample
  std::vector<double> sums_;          // of one sample, of the lines before each
  std::vector<float> blurred_;        // one sample of all lines
  std::optional<FrameSpeckle> speckle_;
  std::vector<std::int16_t> greys_;  // by the upper half of the bits of a power
  std::array<std::int16_t, 256> speckle_greys_;
  std::optional<ScanConverter> converter_;
  std::vector<std::uint8_t> scanned_;  // samples x lines, for the converter
};

}  // namespace fanlight
