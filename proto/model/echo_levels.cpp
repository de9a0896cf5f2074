// SPDX-License-Identifier: Apache-2.0
#include "proto/model/echo_levels.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fanlight {

namespace {

// Of an edge that a beam has blurred, half of the amplitude is left at the true place: 6 dB below the tissue.
// The brightest part of speckled tissue, which the shader takes for its level (surface_place.h), is brighter
// than its mean by some 2 dB more. The usual reach moves a surface into the tissue, from a level that is
// lower by so much (measured: scanned scenes of renderer/RESULTS.md).
constexpr double kEdgeBelowTissueDb = 8.4;
constexpr double kUsualReach = 0.6;
constexpr double kLowerByReachDb = 1.6;
// The same 6 dB below the peak of a thin sheet. The mean of two samples, which the shader takes for the peak,
// is lower than the peak by some 2 dB (sheets of 0.3 to 1 mm there).
constexpr double kFrontBelowPeakDb = 4.2;
// Standard deviation of fully developed speckle, log-compressed: of 20 log10 of Rayleigh's distribution. It
// says how many grey levels a decibel has. Scanners that smooth have less, and seem to have a wider range.
constexpr double kSpeckleDb = 5.57;
// As of a contrast of 50 dB: speckle that a scanner has smoothed away says nothing about decibels.
constexpr double kMostRise = 0.83;
// Halves of the detector's window are means over some cells of speckle, which differ by less than its
// deviation (measured: a sheet of 0.45 mm needs a step of less, and 0.65 shows no more in the scanned scenes'
// fluid).
constexpr double kStepOverSpeckle = 0.65;
// Contrast that speckle alone reaches on less than 0.5 % of the rays, in deviations of the speckle before any
// filter: the difference of the brightest and the darkest mean of four samples within some mm. With and
// without a filter (measured: "Speckle alone" in renderer/RESULTS.md).
constexpr double kReducedContrast = 1.6;
constexpr double kRawContrast = 3;
// Where there is tissue, thin sheets and slopes between two frames have less contrast than other surfaces:
// at 1.6 a sheet of 0.45 mm has holes.
constexpr double kKnownContrast = 1.3;
// No step exceeds it.
constexpr double kNoThreshold = 255;
// So far below any peak that the shader takes the lowest level, halfway from the fluid.
constexpr double kHalfway = 255;

}  // namespace

double EchoLevels::threshold() const {
  if (flat) return kNoThreshold;
  const double speckle = linear() ? 0 : noise;
  return std::clamp(std::max(0.16 * (tissue - fluid), kStepOverSpeckle * speckle), 5.0, 100.0);
}

double EchoLevels::rise(double reach) const {
  // Where the echo is an amplitude, halfway is the middle of the blur.
  if (!known || linear()) return 0.5;
  const double below_db = kEdgeBelowTissueDb + kLowerByReachDb * std::min(reach / kUsualReach, 1.0);
  const double below_tissue = below_db * levels_per_db();
  return std::clamp(1 - below_tissue / (tissue - fluid), 0.5, kMostRise);
}

double EchoLevels::sheet_below() const {
  if (!known || linear()) return kHalfway;
  return kFrontBelowPeakDb * levels_per_db();
}

double EchoLevels::levels_per_db() const {
  return noise / kSpeckleDb;
}

double EchoLevels::least_contrast(bool reduced) const {
  if (flat && noise == 0) return kNoThreshold;
  if (flat) return (reduced ? kReducedContrast : kRawContrast) * noise;
  // Without log compression, tissue in a shadow would be lost with the speckle.
  return known && !linear() ? kKnownContrast * noise : 0;
}

std::string sentence(const EchoLevels& levels) {
  if (levels.flat)
    return "from the data: fluid and tissue differ by no more than the speckle; only what stands out from it "
           "is shown";
  if (!levels.known) return "from the data: fluid and tissue cannot be distinguished";
  return fmt::format(
      "from the data: fluid {:.0f}, tissue {:.0f}, speckle {:.0f} grey levels{}; threshold {:.0f}, "
      "least tissue {:.0f}",
      levels.fluid, levels.tissue, levels.noise, levels.linear() ? " (not log-compressed)" : "",
      levels.threshold(), levels.least_tissue());
}

}  // namespace fanlight
