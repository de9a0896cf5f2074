#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "proto/fan_geometry.hpp"
#include "proto/result.hpp"
#include "proto/transfer_function.hpp"

namespace fanlight {

/// How the rays run: side by side, or all from the eye.
enum class Projection : std::uint8_t { kParallel, kPerspective };
/// Pass 0.
enum class SpeckleFilter : std::uint8_t { kNone, kBox, kMedian, kGuided };
/// Which way the echo must step along the ray to be a surface.
enum class EdgeSign : std::uint8_t { kDarkToBright, kBrightToDark, kEither };
/// Where along the ray the surface lies: where the detector first exceeds the threshold (the paper), or at
/// the steepest point of the edge that made it do so.
enum class SurfacePlace : std::uint8_t { kFirstCrossing, kRefined };
/// What the picture shows.
enum class Mode : std::uint8_t {
  kSurface,
  kVolume,
  kSurfaceAndVolume,  ///< side by side, from one pass 1
  kMaximum,           ///< intensity along the ray
  kMinimum,
  kMean,
  kDepth,
  kSlice,   ///< the plane parallel to the picture at Slice::depth_mm
  kSlices,  ///< the three planes through the target, and the surface
};
/// Pass 2's filter of the depth map.
enum class DepthFilter : std::uint8_t { kMean, kGaussian, kEdgePreserving };
/// When the picture follows the probe: when a sweep is whole, or with every frame, which replaces its place
/// in the last sweep.
enum class Refresh : std::uint8_t { kVolume, kFrame };
/// What each pixel counts for in that filter.
enum class FilterWeights : std::uint8_t { kEven, kConfidence };
enum class Normals : std::uint8_t { kThreeNeighbours, kCentral };
enum class LightKind : std::uint8_t { kPoint, kDirectional };
/// Pass 3.
enum class Smoothing : std::uint8_t { kNone, kMean, kDiffusion };
enum class ColourMap : std::uint8_t { kNone, kGrey, kSepia, kGold, kIce, kHeat };
/// What happens where the machine cannot keep up.
enum class DeadlinePlan : std::uint8_t { kOff, kHoldRate };

/// Everything that a person may change about a picture. Plain numbers; the ranges, units and meanings
/// stand in scene_fields(), the one table from which the command line, the network and the page read them.
///
/// The view frame, in which depth and light are given: origin at the picture's centre in the view plane,
/// right and up along the picture, depth away from the viewer, mm. A depth is a distance from the view plane,
/// in perspective too. At yaw = pitch = roll = 0 the viewer sits behind the probe and looks into the body:
/// right is +x (lateral), up is +z (elevation), depth is +y.
struct Scene {
  struct Camera {
    Point target;  ///< the point that the orbit keeps in the middle
    double yaw_deg = 0;
    double pitch_deg = 0;
    double roll_deg = 0;
    double distance_mm = 0;  ///< from the view plane to the target
    double field_mm = 160;   ///< height of the picture in the body, at the target
    Projection projection = Projection::kParallel;
    double opening_deg = 30;  ///< perspective: angle between the picture's top and bottom, seen from the eye
  } camera;

  struct Rays {
    double start_mm = 0;  ///< depth at which sampling begins
    double end_mm = 160;
    double step_mm = 0;  ///< 0: the finest distance of pixels in the frame
    int window = 1;  ///< each sample is the mean of window x window ones, a step apart across the ray; odd
    int stride = 1;  ///< one ray for stride x stride pixels, through the first of them
  } rays;

  /// Nothing outside is shown: a box in the transducer frame, and two planes.
  struct Crop {
    double left_mm = -1000;
    double right_mm = 1000;
    double near_mm = -1000;
    double far_mm = 1000;
    double below_mm = -1000;
    double above_mm = 1000;
  } crop;
  /// Keeps the points p with normal . p >= distance |normal|; a normal of zero keeps everything.
  struct Clip {
    double normal_x = 0;
    double normal_y = 0;
    double normal_z = 0;
    double distance_mm = 0;
  } clip1, clip2;

  struct Speckle {
    SpeckleFilter filter = SpeckleFilter::kGuided;
    int size = 7;         ///< side of its window in the frame, pixels, odd
    int across = 1;       ///< frames that it spans, odd
    double noise = 0.52;  ///< guided: deviation of speckle over its mean (Rayleigh: 0.52)

    bool operator==(const Speckle&) const = default;
  } speckle;

  struct Detector {
    double threshold = 20;  ///< grey levels of 255
    int window = 28;        ///< samples, even
    EdgeSign sign = EdgeSign::kDarkToBright;
    SurfacePlace place = SurfacePlace::kRefined;
  } detector;

  TransferFunction transfer;

  struct Slice {
    double depth_mm = 80;  ///< of the plane in Mode::kSlice
  } slice;

  struct Filter {
    DepthFilter kind = DepthFilter::kGaussian;
    int size = 21;  ///< side of its window, pixels, odd
    FilterWeights weights = FilterWeights::kEven;
    double step_mm = 6;  ///< depths that differ by more are two surfaces
    int islands = 7;     ///< smaller surfaces than about half this, pixels, are removed; odd, 1 removes none
    int holes = 9;       ///< smaller holes than about half this, pixels, are filled; odd, 1 fills none
    double steady = 0;   ///< share of the last volume's depths in this one's

    bool operator==(const Filter&) const = default;
  } filter;

  struct Light {
    LightKind kind = LightKind::kPoint;
    double right_mm = -90;  ///< a directional light shines from here to the target
    double up_mm = 90;
    double depth_mm = -80;
    double red = 1;  ///< as displayed (sRGB)
    double green = 1;
    double blue = 1;
    double ambient = 0.2;
    double diffuse = 0.75;
    double specular = 0.25;
    double shininess = 24;
    Normals normals = Normals::kCentral;
  } light;

  /// Colour of the surface under white light, as displayed (sRGB): skin.
  struct Material {
    double red = 0.95;
    double green = 0.78;
    double blue = 0.68;
  } material;

  struct Shadow {
    double coefficient = 0.3;  ///< share of the direct light left in a shadow; 1 casts none
    double softness_mm = 15;   ///< radius of the lamp; 0 makes hard shadows
  } shadow;

  Mode mode = Mode::kSurface;
  Refresh refresh = Refresh::kVolume;

  struct Finish {
    Smoothing smoothing = Smoothing::kMean;
    int iterations = 5;       ///< of the diffusion
    double conductance = 12;  ///< of the diffusion, grey levels: steps well above it stay
    ColourMap colours = ColourMap::kNone;
  } finish;

  /// Held by renderer/deadline.hpp, where pictures are made one after the other; one by itself has no rate.
  struct Deadline {
    DeadlinePlan plan = DeadlinePlan::kOff;
    double rate_hz = 15;  ///< wanted pictures a second
  } deadline;
};

/// The first pass that a change of a field runs again.
enum class FirstPass : std::uint8_t { kPrepare, kCast, kFilter, kLight, kNone };

/// One row of the table of all scene fields: a number, a choice, which travels as its index, or a text.
struct SceneField {
  std::string_view name;  ///< dotted, as in the protobuf message Scene and on the command line
  std::string_view unit;  ///< "mm", "deg", "grey levels", ... or empty
  std::string_view help;  ///< one clause for a person
  double minimum = 0;     ///< of a number, or the first choice
  double maximum = 0;
  double step = 0;  ///< 0: any value in between; otherwise minimum + a whole number of steps
  FirstPass first_pass = FirstPass::kNone;
  std::span<const std::string_view> choices;  ///< names of the values 0, 1, ...; empty for a number or text

  // Of a number or a choice; null for a text.
  double (*get)(const Scene&) = nullptr;
  void (*set)(Scene&, double) = nullptr;
  // Of a text; null for the others.
  std::string (*get_text)(const Scene&) = nullptr;
  Result<void> (*set_text)(Scene&, std::string_view) = nullptr;

  bool (*same)(const Scene&, const Scene&) = nullptr;
  void (*copy)(Scene& to, const Scene& from) = nullptr;

  bool is_text() const { return get_text != nullptr; }
};

std::span<const SceneField> scene_fields();

/// The row of that name, or nullptr.
const SceneField* find_scene_field(std::string_view name);

/// Sets one field, or says which value was refused and what is allowed; then the scene is untouched.
/// Precondition: not a text.
Result<void> set_field(Scene& scene, const SceneField& field, double value);

/// The same from text: a number, the name of a choice, or a text.
Result<void> set_field(Scene& scene, const SceneField& field, std::string_view text);

/// A field as set_field() would read it.
std::string field_text(const Scene& scene, const SceneField& field);

/// A bound on what one ray can cost.
inline constexpr double kMostSamplesOnARay = 8192;

/// What the table cannot say because it concerns several fields: rays must start before they end and take
/// at most kMostSamplesOnARay samples, and the crop box must have an inside.
Result<void> check(const Scene& scene);

/// The earliest pass that has to run again to get from one scene's picture to the other's.
FirstPass first_pass_changed(const Scene& from, const Scene& to);

/// `cast` with the fields of `newest` that passes 2 and 3 alone read (those from FirstPass::kFilter on): what
/// can be shown of a new scene with the depth map of an old one.
Scene relit(const Scene& cast, const Scene& newest);

/// A scene that shows the whole fan from the probe: the view plane in the probe face, rays down to the last
/// row, the sweep's middle in the middle, the light up and to the left; every field within the table's range.
/// The windows of pass 2, in pixels, suit a picture of that height.
Scene scene_for(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad,
                std::uint32_t picture_height = 512);

}  // namespace fanlight
