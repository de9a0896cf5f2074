// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/model/cut_list.hpp"
#include "proto/model/deadline.hpp"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/transfer_function.hpp"

namespace fanlight {

/// Direction of the rays: parallel, or from the eye.
enum class Projection : std::uint8_t { kParallel, kPerspective };
/// Filter of pass 0.
enum class SpeckleFilter : std::uint8_t { kNone, kBox, kMedian, kGuided };
/// Sign of the intensity step along the ray that makes a surface.
enum class EdgeSign : std::uint8_t { kDarkToBright, kBrightToDark, kEither };
/// Position of the surface on the ray. An edge is found by a wide window; the others place it within that
/// window.
enum class SurfacePlace : std::uint8_t {
  kFirstCrossing,  ///< where the detector first exceeds the threshold, as in the paper
  kRefined,        ///< the steepest point of that edge
  kTwoScales,      ///< the first steep point by a window of four samples
  kRidge,          ///< the brightest point
  kLevel,          ///< where the echo comes near to that of the tissue behind the edge
};
/// The steps, as long as the frame spacing, of a surface that is slanted to the frames: between two
/// frames their echoes are mixed.
enum class FrameSteps : std::uint8_t {
  kKept,
  kRemoved,  ///< by the mean over one frame spacing, across the frames
};
/// The tissue next to the probe: all before the first fluid, such as the belly's wall, or all before the near
/// wall of a closed bright shell, such as a skull (where there is none, all before the first fluid).
enum class NearTissueShow : std::uint8_t {
  kShown,
  kRemoved,  ///< rays start where it ends, if the volume shows that
};
/// Content of the picture.
enum class Mode : std::uint8_t {
  kSurface,
  kVolume,
  kSurfaceAndVolume,  ///< side by side, from one run of pass 1
  kMaximum,           ///< intensity along the ray
  kMinimum,
  kMean,
  kDepth,
  kSlice,       ///< the plane parallel to the picture at Slice::depth_mm
  kSlices,      ///< three planes through the target, and the surface
  kTomography,  ///< nine parallel planes, three in a row
};
/// What a plane with a thickness shows of the echoes in it, across the plane.
enum class Slab : std::uint8_t {
  kMean,
  kMaximum,
  kXRay,  ///< what a ray through it loses: the more, the thicker and brighter
};
/// The planes of Mode::kTomography, by the letters of Mode::kSlices; where they are not turned:
enum class SlicePlane : std::uint8_t {
  kA,     ///< in the plane of a frame in the middle of the sweep
  kB,     ///< across the frames
  kC,     ///< at constant depth
  kView,  ///< parallel to the picture
};
/// Filter of the depth map in pass 2.
enum class DepthFilter : std::uint8_t { kMean, kGaussian, kEdgePreserving };
/// When the picture is updated: after each whole sweep, or with every frame, which replaces its position in
/// the last sweep.
enum class Refresh : std::uint8_t { kVolume, kFrame };
/// Weight of each pixel in the depth filter.
enum class FilterWeights : std::uint8_t { kEven, kConfidence };
enum class Normals : std::uint8_t { kThreeNeighbours, kCentral };
enum class LightKind : std::uint8_t { kPoint, kDirectional };
enum class LightSwitch : std::uint8_t { kOff, kOn };
/// Smoothing of pass 3.
enum class Smoothing : std::uint8_t { kNone, kMean, kDiffusion };
/// Light to what a screen can show: as it is, or bright light compressed as on film.
enum class Tone : std::uint8_t { kLinear, kFilm };
enum class ColourMap : std::uint8_t { kNone, kGrey, kSepia, kGold, kIce, kHeat };
/// Reaction when the machine is too slow for the requested rate.
enum class DeadlinePlan : std::uint8_t {
  kOff,
  kHoldRate,
  kSmoothWhileMoving,  ///< coarse while the view moves, whatever the rate
};

/// All parameters of a picture that a user may change, as plain numbers. Ranges, units and meanings are in
/// scene_fields(), the one table that the command line, the network and the page read.
///
/// Depth and light are given in the view frame, mm: origin at the picture's centre in the view plane, right
/// and up along the picture, depth away from the viewer. A depth is a distance from the view plane, in
/// perspective too. At yaw = pitch = roll = 0 the viewer is behind the probe and looks into the body: right
/// is +x (lateral), up is +z (elevation), depth is +y.
struct Scene {
  struct Camera {
    Point target;  ///< centre of the orbit
    double yaw_deg = 0;
    double pitch_deg = 0;
    double roll_deg = 0;
    double distance_mm = 0;  ///< from the view plane to the target
    double field_mm = 160;   ///< height of the picture in the body, at the depth of the target
    Projection projection = Projection::kParallel;
    double opening_deg = 30;  ///< perspective: angle between the picture's top and bottom, seen from the eye
  } camera;

  struct Rays {
    double start_mm = 0;  ///< depth at which sampling begins
    double end_mm = 160;
    double step_mm = 0;  ///< 0: the finest pixel distance of the frame
    int window = 1;      ///< steps across the ray over which each sample is averaged, odd
    int stride = 1;      ///< one ray for stride x stride pixels, through the first of them
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

  /// Nothing inside is shown either.
  struct Cuts {
    CutList shapes;
  } cuts;

  struct Near {
    NearTissueShow tissue = NearTissueShow::kShown;
    NearTissueShow before_bone = NearTissueShow::kShown;
    double shift_mm = 0;  ///< of where it ends, away from the probe

    bool is_removed() const {
      return tissue == NearTissueShow::kRemoved || before_bone == NearTissueShow::kRemoved;
    }
  } near;

  struct Speckle {
    SpeckleFilter filter = SpeckleFilter::kGuided;
    int size = 7;         ///< side of the window in the frame, pixels, odd
    double size_mm = 0;   ///< the same; 0: `size` holds
    int across = 1;       ///< number of frames in the window, odd
    double noise = 0.52;  ///< guided: standard deviation of speckle divided by its mean (Rayleigh: 0.52)
    double levels = 0;    ///< guided, where noise is 0: standard deviation in grey levels; 0: from the data

    bool operator==(const Speckle&) const = default;
  } speckle;

  struct Detector {
    double threshold = 20;  ///< grey levels, of 255; 0: from the data
    int window = 28;        ///< samples, even
    double window_mm = 0;   ///< the same; 0: `window` holds
    EdgeSign sign = EdgeSign::kDarkToBright;
    SurfacePlace place = SurfacePlace::kRefined;
    double rise = 0;         ///< place level: share of the way from the fluid to the tissue; 0: from the data
    double reach = 0;        ///< place level: share of the length of the rise; 0: none
    double sheet_below = 0;  ///< place level: of a thin sheet's front below its peak; 0: from the data
    double least_tissue = 0;    ///< place level: of an echo behind an edge, grey levels; 0: from the data
    double least_contrast = 0;  ///< between fluid and tissue, grey levels; 0: from the data
    FrameSteps frame_steps = FrameSteps::kKept;
  } detector;

  TransferFunction transfer;

  struct Slice {
    double depth_mm = 80;  ///< of the plane in Mode::kSlice
    double slab_mm = 0;    ///< thickness of what a plane shows; 0: thin
    Slab slab = Slab::kMean;
    SlicePlane plane = SlicePlane::kA;  ///< in Mode::kTomography: the fifth one goes through the target
    double step_mm = 5;                 ///< between them
    /// Turn of the planes A, B and C about the target, by the angles of the camera. At 0 they lie along the
    /// sweep.
    double yaw_deg = 0;
    double pitch_deg = 0;
    double roll_deg = 0;
  } slice;

  struct Filter {
    DepthFilter kind = DepthFilter::kGaussian;
    int size = 21;       ///< side of the window, pixels, odd
    double size_mm = 0;  ///< the same, in the body at the target; 0: `size` holds
    FilterWeights weights = FilterWeights::kEven;
    double step_mm = 6;  ///< larger depth differences separate two surfaces
    int islands = 7;     ///< surfaces smaller than about half this, pixels, are removed; odd; 1: none
    int holes = 9;       ///< holes smaller than about half this, pixels, are filled; odd; 1: none
    double steady = 0;   ///< share of earlier volumes in a running mean, as of 1 / (1 - steady) volumes
    /// With Refresh::kFrame: frames over which the surface of a new sweep takes the place of the last one's;
    /// 0: at once.
    int seam_frames = 6;

    bool operator==(const Filter&) const = default;
  } filter;

  struct Light {
    LightKind kind = LightKind::kPoint;
    double right_mm = -90;  ///< position; a directional light shines from here to the target
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
    double occlusion = 0;      ///< share of the ambient light that hollows may lose
    double occlusion_mm = 12;  ///< radius of the neighbourhood that hides it
    double fade_mm = 0;        ///< the surface fades this far before it ends in nothing known; 0: not
    double rim = 0;            ///< light on what turns away from the viewer
    double half_mm = 0;        ///< beyond the target the light falls to half in this distance; 0: not
    double haze = 0;           ///< light of what shows no surface, below which no surface falls, 0 to 1
    LightSwitch on = LightSwitch::kOn;
    double strength = 1;  ///< factor of its direct light
  } light;

  /// A light in addition to `light`, of the same kind, and with the same reflection and shadows.
  struct Lamp {
    LightSwitch on = LightSwitch::kOff;
    double right_mm = 0;
    double up_mm = 0;
    double depth_mm = -80;
    double red = 1;  ///< as displayed (sRGB)
    double green = 1;
    double blue = 1;
    double strength = 0.5;
  } fill_light, back_light;

  /// Colour of the surface under white light (sRGB); default: skin.
  struct Material {
    double red = 0.95;
    double green = 0.78;
    double blue = 0.68;
    double scatter_mm = 0;  ///< how far light spreads under the surface (standard deviation); 0: not at all
    double glow = 0;        ///< share of the light from behind that thin parts let through
  } material;

  struct Glass {
    double amount =
        0;  ///< 0: opaque; 1: the surface and the edges behind it are seen by their outlines alone
  } glass;

  struct Shadow {
    double coefficient = 0.3;  ///< fraction of the direct light that remains in a shadow; 1: no shadows
    double softness_mm = 15;   ///< radius of the light source; 0: hard shadows
  } shadow;

  Mode mode = Mode::kSurface;
  Refresh refresh = Refresh::kVolume;

  struct Finish {
    Smoothing smoothing = Smoothing::kMean;
    int iterations = 5;       ///< of the diffusion
    double conductance = 12;  ///< of the diffusion, grey levels: much larger steps are preserved
    ColourMap colours = ColourMap::kNone;
    double exposure = 1;  ///< factor of all light
    int outline = 0;      ///< pixels to either side by which outlines get smooth; 0: stairs
    Tone tone = Tone::kLinear;
  } finish;

  /// Applied by renderer/schedule/rate_governor.hpp to a sequence of pictures; a single picture has no rate.
  struct Deadline {
    DeadlinePlan plan = DeadlinePlan::kOff;
    double rate_hz = 15;  ///< requested picture rate
  } deadline;

  /// Of the picture, where it differs from the renderer's usual size. Not a field that displays set: each
  /// asks for the pixels that it shows, and renderer/schedule/size_governor.hpp decides.
  std::optional<PictureSize> size;
};

/// A scene and the number under which the server accepted it.
struct NumberedScene {
  std::uint64_t revision = 0;  ///< grows with each change
  Scene scene;
  DeadlineState deadline{};  ///< differs from the default where the deadline plan modified `scene`
};

/// Earliest pass that must run again after a change of a field.
enum class FirstPass : std::uint8_t { kPrepare, kCast, kFilter, kLight, kNone };

/// A row of the table of scene fields: a number, a choice (transmitted as its index), or a text.
struct SceneField {
  std::string_view name;  ///< dotted, as in the protobuf message Scene and on the command line
  std::string_view unit;  ///< "mm", "deg", "grey levels", ... or empty
  std::string_view help;  ///< one clause for users
  double minimum = 0;     ///< of a number, or index of the first choice
  double maximum = 0;
  double step = 0;  ///< 0: continuous; otherwise minimum + a whole number of steps
  FirstPass first_pass = FirstPass::kNone;
  std::span<const std::string_view> choices;  ///< names of the values 0, 1, ...; empty for a number or text

  // Of a number or a choice; nullptr for a text. Setting a window in samples or pixels sets the one in mm,
  // whose row comes after it, to 0.
  double (*get)(const Scene&) = nullptr;
  void (*set)(Scene&, double) = nullptr;
  // Of a text; nullptr for the others.
  std::string (*get_text)(const Scene&) = nullptr;
  Result<void> (*set_text)(Scene&, std::string_view) = nullptr;

  bool (*same)(const Scene&, const Scene&) = nullptr;
  void (*copy)(Scene& to, const Scene& from) = nullptr;

  bool is_text() const { return get_text != nullptr; }
};

std::span<const SceneField> scene_fields();

/// The row with this name, or nullptr.
const SceneField* find_scene_field(std::string_view name);

/// Sets one field. The error names the refused value and the allowed ones; the scene is then unchanged.
/// Precondition: not a text.
Result<void> set_field(Scene& scene, const SceneField& field, double value);

/// The same from a text: a number, the name of a choice, or a text field's content.
Result<void> set_field(Scene& scene, const SceneField& field, std::string_view text);

/// The field's value as text that set_field() accepts.
std::string field_text(const Scene& scene, const SceneField& field);

/// Limits the cost of a ray.
inline constexpr double kMostSamplesOnARay = 8192;

/// Samples that a detector's window may have.
inline constexpr int kMostDetectorWindow = 32;

/// Whether the picture needs surfaces.
bool finds_surface(Mode mode);

/// Whether pass 1 keeps the edges behind the surface.
bool is_glass(const Scene& scene);

/// Distance of samples along a ray, mm: that of the scene, else the finest distance of pixels; in modes that
/// need surfaces so that a detector's window in mm fits into the samples that a window may have.
double sample_step_mm(const Scene& scene, double finest_mm);

/// Rules that concern several fields: rays must start before they end and take at most kMostSamplesOnARay
/// samples, and the crop box must not be empty.
Result<void> check(const Scene& scene);

/// Brings every number into its field's range.
void limit(Scene& scene);

/// Earliest pass that must run again to change one scene's picture into the other's.
FirstPass first_pass_changed(const Scene& from, const Scene& to);

/// `cast` with those fields of `newest` that only passes 2 and 3 read (from FirstPass::kFilter on): the part
/// of a new scene that can be shown with an existing depth map.
Scene relit(const Scene& cast, const Scene& newest);

/// Places the fill light before the target, opposite the usual side of the light, and the back light above
/// and behind it, at distances in proportion to what the camera shows.
void place_fill_and_back_light(Scene& scene);

/// Scene that shows the whole fan from the probe: the view plane in the probe face, rays down to the last
/// row, the middle of the sweep in the centre, the light up and to the left. Windows are in mm, threshold and
/// noise from the data. Every field is within the table's range. Islands and holes, in pixels, are scaled to
/// `picture_height`.
Scene scene_for(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad,
                std::uint32_t picture_height = 512);

}  // namespace fanlight
