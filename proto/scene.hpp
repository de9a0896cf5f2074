#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "proto/fan_geometry.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// Which way the echo must step along the ray to be a surface.
enum class EdgeSign : std::uint8_t { kDarkToBright, kBrightToDark, kEither };
/// What the picture shows: the lit surface, or the composited volume.
enum class Mode : std::uint8_t { kSurface, kVolume };
/// Pass 3.
enum class Finish : std::uint8_t { kNone, kMean };

/// Everything that a person may change about a picture. Plain numbers; the ranges, units and meanings
/// stand in scene_fields(), the one table from which the command line, the network and the page read them.
///
/// The view frame, in which depth and light are given: origin at the picture's centre in the view plane,
/// right and up along the picture, depth away from the viewer, mm. Rays are parallel to depth and start in
/// the view plane. At yaw = pitch = roll = 0 the viewer sits behind the probe and looks into the body: right
/// is +x (lateral), up is +z (elevation), depth is +y.
struct Scene {
  struct Camera {
    Point target;  ///< the point that the orbit keeps in the middle
    double yaw_deg = 0;
    double pitch_deg = 0;
    double roll_deg = 0;
    double distance_mm = 0;  ///< from the view plane to the target
    double field_mm = 160;   ///< height of the picture in the body
  } camera;

  struct Rays {
    double start_mm = 0;  ///< depth at which sampling begins
    double end_mm = 160;
    double step_mm = 0;  ///< 0: the finer of the frame's two pixel sizes
  } rays;

  struct Detector {
    double threshold = 25;  ///< grey levels of 255
    int window = 20;        ///< samples, even
    EdgeSign sign = EdgeSign::kDarkToBright;
  } detector;

  /// Opacity ramp of the composited volume.
  struct Transfer {
    double transparent = 60;      ///< grey level up to which nothing is seen
    double opaque = 255;          ///< grey level at which a millimetre has the full opacity
    double opacity_per_mm = 0.3;  ///< share of the light that a millimetre of it stops
  } transfer;

  struct Filter {
    int size = 13;  ///< side of the moving average over the depth map, pixels, odd
  } filter;

  struct Light {
    double right_mm = -90;
    double up_mm = 90;
    double depth_mm = -80;
    double ambient = 0.2;
    double diffuse = 0.75;
    double specular = 0.25;
    double shininess = 24;
  } light;

  struct Shadow {
    double coefficient = 0.6;  ///< brightness left in a shadow; 1 casts none
  } shadow;

  Mode mode = Mode::kSurface;
  Finish finish = Finish::kMean;
};

/// The first pass that a change of a field runs again.
enum class FirstPass : std::uint8_t { kCast, kLight, kNone };

/// One row of the table of all scene fields. Choices travel as their index.
struct SceneField {
  std::string_view name;  ///< dotted, as in the protobuf message Scene and on the command line
  std::string_view unit;  ///< "mm", "deg", "grey levels", ... or empty
  std::string_view help;  ///< one clause for a person
  double minimum;
  double maximum;
  double step;  ///< 0: any value in between; otherwise minimum + a whole number of steps
  FirstPass first_pass;
  std::span<const std::string_view> choices;  ///< names of the values 0, 1, ...; empty for a number
  double (*get)(const Scene&);
  void (*set)(Scene&, double);
};

std::span<const SceneField> scene_fields();

/// The row of that name, or nullptr.
const SceneField* find_scene_field(std::string_view name);

/// Sets one field, or says which value was refused and what is allowed; then the scene is untouched.
Result<void> set_field(Scene& scene, const SceneField& field, double value);

/// The same from text: a number, or the name of a choice.
Result<void> set_field(Scene& scene, const SceneField& field, std::string_view text);

/// A bound on what one ray can cost.
inline constexpr double kMostSamplesOnARay = 8192;

/// What the table cannot say because it concerns several fields: rays must start before they end and take
/// at most kMostSamplesOnARay samples, and the transfer ramp must rise.
Result<void> check(const Scene& scene);

/// The earliest pass that has to run again to get from one scene's picture to the other's.
FirstPass first_pass_changed(const Scene& from, const Scene& to);

/// `cast` with the fields of `newest` that passes 2 and 3 alone read: what can be shown of a new scene with
/// the depth map of an old one.
Scene relit(const Scene& cast, const Scene& newest);

/// A scene that shows the whole fan from the probe: the view plane in the probe face, rays down to the last
/// row, the sweep's middle in the middle, the light up and to the left; every field within the table's range.
Scene scene_for(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad);

}  // namespace fanlight
