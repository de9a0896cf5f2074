// SPDX-License-Identifier: Apache-2.0
#include "proto/model/scene.hpp"

#include <algorithm>
#include <string>
#include <type_traits>

namespace fanlight {

namespace {

constexpr std::string_view kProjections[] = {"parallel", "perspective"};
constexpr std::string_view kSpeckleFilters[] = {"none", "box", "median", "guided"};
constexpr std::string_view kSigns[] = {"dark-to-bright", "bright-to-dark", "either"};
constexpr std::string_view kPlaces[] = {"first-crossing", "refined", "two-scales", "ridge", "level"};
constexpr std::string_view kFrameSteps[] = {"kept", "removed"};
constexpr std::string_view kNearTissue[] = {"shown", "removed"};
constexpr std::string_view kRefreshes[] = {"volume", "frame"};
constexpr std::string_view kModes[] = {
    "surface", "volume", "surface-and-volume", "maximum", "minimum", "mean", "depth",
    "slice",   "slices", "tomography"};
constexpr std::string_view kSlicePlanes[] = {"a", "b", "c", "view"};
constexpr std::string_view kSlabs[] = {"mean", "maximum", "x-ray"};
constexpr std::string_view kDepthFilters[] = {"mean", "gaussian", "edge-preserving"};
constexpr std::string_view kWeights[] = {"even", "confidence"};
constexpr std::string_view kNormals[] = {"three-neighbours", "central"};
constexpr std::string_view kSwitch[] = {"off", "on"};
constexpr std::string_view kLightKinds[] = {"point", "directional"};
constexpr std::string_view kSmoothings[] = {"none", "mean", "diffusion"};
constexpr std::string_view kTones[] = {"linear", "film"};
constexpr std::string_view kColourMaps[] = {"none", "grey", "sepia", "gold", "ice", "heat"};
constexpr std::string_view kDeadlinePlans[] = {"off", "hold-rate", "smooth-while-moving"};

using Choices = std::span<const std::string_view>;

// One accessor for reading and writing, so that a row names its member once.
template <auto kMember>
const auto& member_of(const Scene& scene) {
  return kMember(const_cast<Scene&>(scene));
}

template <auto kMember>
SceneField any_row(std::string_view name, std::string_view unit, std::string_view help,
                   FirstPass first_pass) {
  SceneField field{.name = name, .unit = unit, .help = help, .first_pass = first_pass, .choices = {}};
  field.same = [](const Scene& a, const Scene& b) { return member_of<kMember>(a) == member_of<kMember>(b); };
  field.copy = [](Scene& to, const Scene& from) { kMember(to) = member_of<kMember>(from); };
  return field;
}

template <auto kMember>
SceneField row(std::string_view name, std::string_view unit, std::string_view help, double minimum,
               double maximum, double step, FirstPass first_pass) {
  SceneField field = any_row<kMember>(name, unit, help, first_pass);
  field.minimum = minimum;
  field.maximum = maximum;
  field.step = step;
  field.get = [](const Scene& scene) { return static_cast<double>(member_of<kMember>(scene)); };
  field.set = [](Scene& scene, double value) {
    auto& member = kMember(scene);
    member = static_cast<std::remove_reference_t<decltype(member)>>(value);
  };
  return field;
}

/// A number that takes the place of one in mm: who sets it does not want the other any more.
template <auto kMember, auto kMillimetres>
SceneField row_instead(std::string_view name, std::string_view unit, std::string_view help, double minimum,
                       double maximum, double step, FirstPass first_pass) {
  SceneField field = row<kMember>(name, unit, help, minimum, maximum, step, first_pass);
  field.set = [](Scene& scene, double value) {
    kMember(scene) = static_cast<int>(value);
    kMillimetres(scene) = 0;
  };
  return field;
}

template <auto kMember>
SceneField choice(std::string_view name, std::string_view help, FirstPass first_pass, Choices choices) {
  SceneField field = row<kMember>(name, "", help, 0, static_cast<double>(choices.size() - 1), 1, first_pass);
  field.choices = choices;
  return field;
}

/// A member with text() and parse().
template <auto kMember>
SceneField text_row(std::string_view name, std::string_view help, FirstPass first_pass) {
  SceneField field = any_row<kMember>(name, "", help, first_pass);
  field.get_text = [](const Scene& scene) { return member_of<kMember>(scene).text(); };
  field.set_text = [](Scene& scene, std::string_view text) -> Result<void> {
    auto& member = kMember(scene);
    auto parsed = std::remove_reference_t<decltype(member)>::parse(text);
    if (!parsed) return parsed.error();
    member = *parsed;
    return {};
  };
  return field;
}

// NOLINTBEGIN(bugprone-macro-parentheses): a member path cannot stand in parentheses.
#define MEMBER(path)           \
  [](Scene & scene) -> auto& { \
    return scene.path;         \
  }
// NOLINTEND(bugprone-macro-parentheses)

const SceneField kFields[] = {
    row<MEMBER(camera.target.x_mm)>("camera.target_x_mm", "mm",
                                    "point that the orbit keeps in the middle, lateral", -1000, 1000, 0,
                                    FirstPass::kCast),
    row<MEMBER(camera.target.y_mm)>("camera.target_y_mm", "mm", "the same, below the probe face", -1000, 1000,
                                    0, FirstPass::kCast),
    row<MEMBER(camera.target.z_mm)>("camera.target_z_mm", "mm", "the same, elevation", -1000, 1000, 0,
                                    FirstPass::kCast),
    row<MEMBER(camera.yaw_deg)>("camera.yaw_deg", "deg",
                                "orbit about elevation, positive towards the marked side", -180, 180, 0,
                                FirstPass::kCast),
    row<MEMBER(camera.pitch_deg)>("camera.pitch_deg", "deg", "orbit upwards", -90, 90, 0, FirstPass::kCast),
    row<MEMBER(camera.roll_deg)>("camera.roll_deg", "deg",
                                 "turn of the camera about its view direction, clockwise", -180, 180, 0,
                                 FirstPass::kCast),
    row<MEMBER(camera.distance_mm)>("camera.distance_mm", "mm", "from the view plane to the target", 0, 2000,
                                    0, FirstPass::kCast),
    row<MEMBER(camera.field_mm)>("camera.field_mm", "mm", "height of the picture in the body, at the target",
                                 1, 2000, 0, FirstPass::kCast),
    choice<MEMBER(camera.projection)>("camera.projection", "rays side by side, or all from the eye",
                                      FirstPass::kCast, kProjections),
    row<MEMBER(camera.opening_deg)>(
        "camera.opening_deg", "deg",
        "perspective: angle from the picture's bottom to its top, seen from the eye", 1, 120, 0,
        FirstPass::kCast),
    row<MEMBER(rays.start_mm)>("rays.start_mm", "mm", "depth below the view plane at which rays start", 0,
                               2000, 0, FirstPass::kCast),
    row<MEMBER(rays.end_mm)>("rays.end_mm", "mm", "depth at which they end", 0, 3000, 0, FirstPass::kCast),
    row<MEMBER(rays.step_mm)>("rays.step_mm", "mm",
                              "distance of samples; 0 takes the finest distance of pixels in the frame", 0,
                              10, 0, FirstPass::kCast),
    row<MEMBER(rays.window)>("rays.window", "samples",
                             "width across the ray over which each sample is averaged, odd", 1, 7, 2,
                             FirstPass::kCast),
    row<MEMBER(rays.stride)>("rays.stride", "pixels",
                             "one ray per N by N pixels: 2 is coarse, with a quarter of the rays", 1, 2, 1,
                             FirstPass::kCast),
    choice<MEMBER(near.tissue)>("near.tissue",
                                "the tissue between the probe and the first fluid: shown, or removed where "
                                "the volume shows fluid behind it",
                                FirstPass::kCast, kNearTissue),
    choice<MEMBER(near.before_bone)>(
        "near.before_bone",
        "what lies before a closed bright shell, such as a skull, or else before the first fluid: shown, or "
        "removed where the volume shows one of them",
        FirstPass::kCast, kNearTissue),
    row<MEMBER(near.shift_mm)>("near.shift_mm", "mm",
                               "moves the end of what is removed away from the probe; negative: towards it",
                               -30, 30, 0, FirstPass::kCast),
    row<MEMBER(crop.left_mm)>("crop.left_mm", "mm", "nothing is shown below this lateral position (x)", -1000,
                              1000, 0, FirstPass::kCast),
    row<MEMBER(crop.right_mm)>("crop.right_mm", "mm", "nor above this", -1000, 1000, 0, FirstPass::kCast),
    row<MEMBER(crop.near_mm)>("crop.near_mm", "mm", "nothing is shown nearer to the probe than this (y)",
                              -1000, 1000, 0, FirstPass::kCast),
    row<MEMBER(crop.far_mm)>("crop.far_mm", "mm", "nor farther than this", -1000, 1000, 0, FirstPass::kCast),
    row<MEMBER(crop.below_mm)>("crop.below_mm", "mm", "nothing is shown below this elevation (z)", -1000,
                               1000, 0, FirstPass::kCast),
    row<MEMBER(crop.above_mm)>("crop.above_mm", "mm", "nor above this", -1000, 1000, 0, FirstPass::kCast),
    text_row<MEMBER(cuts.shapes)>(
        "cuts.shapes",
        "what the scalpel has cut away: lassos and balls in the transducer frame; empty shows everything",
        FirstPass::kCast),
    row<MEMBER(clip1.normal_x)>(
        "clip1.normal_x", "",
        "clip plane: what lies along this normal is kept, lateral part; all 0 keeps everything", -1, 1, 0,
        FirstPass::kCast),
    row<MEMBER(clip1.normal_y)>("clip1.normal_y", "", "clip plane: the same, part into the body", -1, 1, 0,
                                FirstPass::kCast),
    row<MEMBER(clip1.normal_z)>("clip1.normal_z", "", "clip plane: the same, part in elevation", -1, 1, 0,
                                FirstPass::kCast),
    row<MEMBER(clip1.distance_mm)>("clip1.distance_mm", "mm",
                                   "clip plane: its distance from the probe face's centre along the normal",
                                   -1000, 1000, 0, FirstPass::kCast),
    row<MEMBER(clip2.normal_x)>(
        "clip2.normal_x", "",
        "second clip plane: what lies along this normal is kept, lateral part; all 0 keeps everything", -1, 1,
        0, FirstPass::kCast),
    row<MEMBER(clip2.normal_y)>("clip2.normal_y", "", "second clip plane: the same, part into the body", -1,
                                1, 0, FirstPass::kCast),
    row<MEMBER(clip2.normal_z)>("clip2.normal_z", "", "second clip plane: the same, part in elevation", -1, 1,
                                0, FirstPass::kCast),
    row<MEMBER(clip2.distance_mm)>(
        "clip2.distance_mm", "mm",
        "second clip plane: its distance from the probe face's centre along the normal", -1000, 1000, 0,
        FirstPass::kCast),
    choice<MEMBER(speckle.filter)>("speckle.filter", "speckle reduction of the volume before rays are cast",
                                   FirstPass::kPrepare, kSpeckleFilters),
    row_instead<MEMBER(speckle.size), MEMBER(speckle.size_mm)>(
        "speckle.size", "pixels", "side of its window in a frame, odd; setting it sets speckle.size_mm to 0",
        3, 7, 2, FirstPass::kPrepare),
    row<MEMBER(speckle.size_mm)>("speckle.size_mm", "mm",
                                 "side of its window in a frame; 0 takes speckle.size", 0, 20, 0,
                                 FirstPass::kPrepare),
    row<MEMBER(speckle.across)>("speckle.across", "frames", "neighbouring frames that it spans, odd", 1, 3, 2,
                                FirstPass::kPrepare),
    row<MEMBER(speckle.noise)>("speckle.noise", "",
                               "guided: deviation of speckle over its mean, for frames that are not "
                               "log-compressed; 0 takes speckle.levels",
                               0, 2, 0, FirstPass::kPrepare),
    row<MEMBER(speckle.levels)>("speckle.levels", "grey levels",
                                "guided: deviation of speckle; what varies more is an edge; 0 measures it", 0,
                                100, 0, FirstPass::kPrepare),
    row<MEMBER(detector.threshold)>("detector.threshold", "grey levels",
                                    "step in the echo that makes a surface; 0 measures fluid and tissue", 0,
                                    255, 0, FirstPass::kCast),
    row_instead<MEMBER(detector.window), MEMBER(detector.window_mm)>(
        "detector.window", "samples",
        "samples that the edge detector compares, even; setting it sets detector.window_mm to 0", 2,
        kMostDetectorWindow, 2, FirstPass::kCast),
    row<MEMBER(detector.window_mm)>("detector.window_mm", "mm",
                                    "length that the edge detector compares; 0 takes detector.window", 0, 50,
                                    0, FirstPass::kCast),
    choice<MEMBER(detector.sign)>("detector.sign", "which way the echo must step", FirstPass::kCast, kSigns),
    choice<MEMBER(detector.place)>(
        "detector.place",
        "where on the edge the surface lies: where the threshold is first crossed, its steepest point, the "
        "steepest point by a narrower window, the brightest point, or where the echo comes near to the "
        "tissue's",
        FirstPass::kCast, kPlaces),
    row<MEMBER(detector.rise)>(
        "detector.rise", "",
        "place level: how far the echo has risen from the fluid's to the tissue's where "
        "the surface lies; 0 asks the data",
        0, 1, 0, FirstPass::kCast),
    row<MEMBER(detector.reach)>(
        "detector.reach", "",
        "place level: moves the surface into the tissue by this share of the length of "
        "the echo's rise beyond 0.5 mm; no effect without log compression or speckle",
        0, 2, 0, FirstPass::kCast),
    row<MEMBER(detector.sheet_below)>("detector.sheet_below", "grey levels",
                                      "place level: how far below its brightest echo a thin bright sheet has "
                                      "its front; 0 asks the data",
                                      0, 255, 0, FirstPass::kCast),
    row<MEMBER(detector.least_tissue)>("detector.least_tissue", "grey levels",
                                       "place level: an edge with no echo so bright behind it is no surface; "
                                       "0 asks the data, 1 takes every edge",
                                       0, 255, 0, FirstPass::kCast),
    row<MEMBER(detector.least_contrast)>(
        "detector.least_contrast", "grey levels",
        "an edge where the fluid before it and the tissue behind it differ by less is no surface; 0 asks the "
        "data for what speckle alone does not reach, 1 takes every edge",
        0, 255, 0, FirstPass::kCast),
    choice<MEMBER(detector.frame_steps)>("detector.frame_steps",
                                         "the steps that mixed echoes between two frames make on a slanted "
                                         "surface: kept, or removed by the mean over "
                                         "one frame spacing",
                                         FirstPass::kCast, kFrameSteps),
    text_row<MEMBER(transfer)>(
        "transfer.points",
        "volume mode: colour and opacity per mm by grey level, as LEVEL #RRGGBB OPACITY, ...",
        FirstPass::kCast),
    row<MEMBER(slice.depth_mm)>("slice.depth_mm", "mm", "slice mode: depth of the plane below the view plane",
                                0, 3000, 0, FirstPass::kCast),
    row<MEMBER(slice.slab_mm)>(
        "slice.slab_mm", "mm",
        "thickness of the slab that planes show, half of it to each side; 0: a thin plane", 0, 30, 0,
        FirstPass::kCast),
    choice<MEMBER(slice.slab)>(
        "slice.slab",
        "what a slab shows of its echoes: the mean, the maximum, or what a ray through it loses",
        FirstPass::kCast, kSlabs),
    choice<MEMBER(slice.plane)>("slice.plane",
                                "planes of the mode tomography: of a frame, across the frames, at constant "
                                "depth, parallel to the picture",
                                FirstPass::kCast, kSlicePlanes),
    row<MEMBER(slice.step_mm)>("slice.step_mm", "mm", "between the planes of the mode tomography", 0.2, 30, 0,
                               FirstPass::kCast),
    row<MEMBER(slice.yaw_deg)>(
        "slice.yaw_deg", "deg",
        "turn of the planes A, B and C about the direction of the sweep, as camera.yaw_deg turns a view",
        -180, 180, 0, FirstPass::kCast),
    row<MEMBER(slice.pitch_deg)>(
        "slice.pitch_deg", "deg",
        "turn of the planes A, B and C about the lateral direction, as camera.pitch_deg turns a view", -90,
        90, 0, FirstPass::kCast),
    row<MEMBER(slice.roll_deg)>(
        "slice.roll_deg", "deg",
        "turn of the planes A, B and C about the depth, as camera.roll_deg turns a view", -180, 180, 0,
        FirstPass::kCast),
    choice<MEMBER(filter.kind)>(
        "filter.kind", "average of depths: moving mean, Gaussian, or one that does not bridge a step",
        FirstPass::kFilter, kDepthFilters),
    row_instead<MEMBER(filter.size), MEMBER(filter.size_mm)>(
        "filter.size", "pixels",
        "side of its window over the depth map, odd; setting it sets filter.size_mm to 0", 1, 31, 2,
        FirstPass::kFilter),
    row<MEMBER(filter.size_mm)>("filter.size_mm", "mm",
                                "side of its window over the depth map, in the body; 0 takes filter.size", 0,
                                100, 0, FirstPass::kFilter),
    choice<MEMBER(filter.weights)>("filter.weights",
                                   "what a pixel counts: all the same, or by the confidence in its edge",
                                   FirstPass::kFilter, kWeights),
    row<MEMBER(filter.step_mm)>("filter.step_mm", "mm", "depths that differ by more are two surfaces", 0.1,
                                100, 0, FirstPass::kFilter),
    row<MEMBER(filter.islands)>("filter.islands", "pixels",
                                "surfaces smaller than about half this are removed; odd, 1 removes none", 1,
                                15, 2, FirstPass::kFilter),
    row<MEMBER(filter.holes)>("filter.holes", "pixels",
                              "holes smaller than about half this are filled; odd, 1 fills none", 1, 15, 2,
                              FirstPass::kFilter),
    row<MEMBER(filter.steady)>(
        "filter.steady", "",
        "share of earlier volumes in a running mean of the depth map, moved with the body; "
        "0.8: as of 5 volumes",
        0, 0.95, 0, FirstPass::kFilter),
    row<MEMBER(filter.seam_frames)>(
        "filter.seam_frames", "frames",
        "frames over which a new sweep's surface replaces the last one's, with refresh frame; 0: at once", 0,
        16, 1, FirstPass::kFilter),
    choice<MEMBER(light.kind)>("light.kind", "at a point, or so far away that its rays are parallel",
                               FirstPass::kLight, kLightKinds),
    row<MEMBER(light.right_mm)>(
        "light.right_mm", "mm",
        "right of the picture's centre; a directional light shines from here to the target", -2000, 2000, 0,
        FirstPass::kLight),
    row<MEMBER(light.up_mm)>("light.up_mm", "mm", "above the picture's centre", -2000, 2000, 0,
                             FirstPass::kLight),
    row<MEMBER(light.depth_mm)>("light.depth_mm", "mm", "beyond the view plane (negative: before it)", -2000,
                                2000, 0, FirstPass::kLight),
    row<MEMBER(light.red)>("light.red", "", "colour of the key light and of the ambient light, red", 0, 1, 0,
                           FirstPass::kLight),
    row<MEMBER(light.green)>("light.green", "", "the same, green", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.blue)>("light.blue", "", "the same, blue", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.ambient)>("light.ambient", "", "light from everywhere", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.diffuse)>("light.diffuse", "", "matt reflection", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.specular)>("light.specular", "", "shiny reflection", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.shininess)>("light.shininess", "", "exponent of the shiny reflection", 1, 256, 0,
                                 FirstPass::kLight),
    choice<MEMBER(light.normals)>("light.normals",
                                  "slope of the surface from three neighbouring pixels, or from both sides",
                                  FirstPass::kLight, kNormals),
    row<MEMBER(light.occlusion)>("light.occlusion", "",
                                 "share of the light from everywhere that hollows and folds lose", 0, 1, 0,
                                 FirstPass::kLight),
    row<MEMBER(light.occlusion_mm)>("light.occlusion_mm", "mm", "size of the hollows that lose it", 0.5, 100,
                                    0, FirstPass::kLight),
    row<MEMBER(light.fade_mm)>(
        "light.fade_mm", "mm",
        "how far before its border the surface fades, where nothing is known beyond; 0 "
        "cuts it off",
        0, 20, 0, FirstPass::kLight),
    row<MEMBER(light.rim)>("light.rim", "", "light on edges that turn away from the viewer", 0, 1, 0,
                           FirstPass::kLight),
    row<MEMBER(light.half_mm)>(
        "light.half_mm", "mm",
        "distance beyond the target in which the light falls to half and turns cooler; 0: "
        "it does not",
        0, 1000, 0, FirstPass::kLight),
    row<MEMBER(light.haze)>("light.haze", "",
                            "light of what shows no surface, below which no surface falls; 0: black", 0, 1, 0,
                            FirstPass::kLight),
    choice<MEMBER(light.on)>(
        "light.on", "the key light, from its place; off leaves the ambient light and the other lights",
        FirstPass::kLight, kSwitch),
    row<MEMBER(light.strength)>("light.strength", "", "factor of the key light", 0, 4, 0, FirstPass::kLight),
    choice<MEMBER(fill_light.on)>(
        "fill_light.on", "a second light, which softens what the first leaves dark; of the same kind",
        FirstPass::kLight, kSwitch),
    row<MEMBER(fill_light.right_mm)>("fill_light.right_mm", "mm", "right of the picture's centre", -2000,
                                     2000, 0, FirstPass::kLight),
    row<MEMBER(fill_light.up_mm)>("fill_light.up_mm", "mm", "above the picture's centre", -2000, 2000, 0,
                                  FirstPass::kLight),
    row<MEMBER(fill_light.depth_mm)>("fill_light.depth_mm", "mm",
                                     "beyond the view plane (negative: before it)", -2000, 2000, 0,
                                     FirstPass::kLight),
    row<MEMBER(fill_light.red)>("fill_light.red", "", "colour of the light, red", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(fill_light.green)>("fill_light.green", "", "colour of the light, green", 0, 1, 0,
                                  FirstPass::kLight),
    row<MEMBER(fill_light.blue)>("fill_light.blue", "", "colour of the light, blue", 0, 1, 0,
                                 FirstPass::kLight),
    row<MEMBER(fill_light.strength)>("fill_light.strength", "", "factor of the light", 0, 4, 0,
                                     FirstPass::kLight),
    choice<MEMBER(back_light.on)>(
        "back_light.on",
        "a third light, which shines from behind on edges and through thin parts; of the same kind",
        FirstPass::kLight, kSwitch),
    row<MEMBER(back_light.right_mm)>("back_light.right_mm", "mm", "right of the picture's centre", -2000,
                                     2000, 0, FirstPass::kLight),
    row<MEMBER(back_light.up_mm)>("back_light.up_mm", "mm", "above the picture's centre", -2000, 2000, 0,
                                  FirstPass::kLight),
    row<MEMBER(back_light.depth_mm)>("back_light.depth_mm", "mm",
                                     "beyond the view plane (negative: before it)", -2000, 2000, 0,
                                     FirstPass::kLight),
    row<MEMBER(back_light.red)>("back_light.red", "", "colour of the light, red", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(back_light.green)>("back_light.green", "", "colour of the light, green", 0, 1, 0,
                                  FirstPass::kLight),
    row<MEMBER(back_light.blue)>("back_light.blue", "", "colour of the light, blue", 0, 1, 0,
                                 FirstPass::kLight),
    row<MEMBER(back_light.strength)>("back_light.strength", "", "factor of the light", 0, 4, 0,
                                     FirstPass::kLight),
    row<MEMBER(material.red)>("material.red", "", "colour of the surface, red", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(material.green)>("material.green", "", "colour of the surface, green", 0, 1, 0,
                                FirstPass::kLight),
    row<MEMBER(material.blue)>("material.blue", "", "colour of the surface, blue", 0, 1, 0,
                               FirstPass::kLight),
    row<MEMBER(material.scatter_mm)>("material.scatter_mm", "mm",
                                     "how far light spreads under the surface, red most; 0 keeps it opaque",
                                     0, 10, 0, FirstPass::kLight),
    row<MEMBER(material.glow)>("material.glow", "",
                               "share of the light from behind that thin parts let through", 0, 1, 0,
                               FirstPass::kLight),
    row<MEMBER(glass.amount)>("glass.amount", "",
                              "0: the surface is opaque; 1: it is glass, and shows the outlines of what "
                              "lies behind it; in the modes surface and slices",
                              0, 1, 0, FirstPass::kLight),
    row<MEMBER(shadow.coefficient)>("shadow.coefficient", "",
                                    "share of the light's own brightness left in a shadow; 1 casts none", 0,
                                    1, 0, FirstPass::kLight),
    row<MEMBER(shadow.softness_mm)>("shadow.softness_mm", "mm",
                                    "radius of the lamp, which blurs the shadow's edge; 0 keeps it hard", 0,
                                    200, 0, FirstPass::kLight),
    // Rays end at the surface in surface mode: the volume's colours are computed only in modes that show
    // them.
    choice<MEMBER(mode)>("mode", "what the picture shows", FirstPass::kCast, kModes),
    choice<MEMBER(finish.smoothing)>(
        "finish.smoothing", "smoothing of the picture: none, 2 x 2 mean, or diffusion that keeps edges",
        FirstPass::kLight, kSmoothings),
    row<MEMBER(finish.iterations)>("finish.iterations", "", "steps of the diffusion", 1, 30, 1,
                                   FirstPass::kLight),
    row<MEMBER(finish.conductance)>("finish.conductance", "grey levels",
                                    "diffusion: steps well above this stay", 1, 100, 0, FirstPass::kLight),
    choice<MEMBER(finish.colours)>("finish.colours", "colour map of the picture's brightness",
                                   FirstPass::kLight, kColourMaps),
    row<MEMBER(finish.exposure)>("finish.exposure", "", "factor of all light on the surface", 0.1, 8, 0,
                                 FirstPass::kLight),
    choice<MEMBER(finish.tone)>("finish.tone",
                                "how bright light is shown: as it is, or compressed as on film",
                                FirstPass::kLight, kTones),
    row<MEMBER(finish.outline)>("finish.outline", "pixels", "how smooth outlines are; 0 leaves stairs", 0, 8,
                                1, FirstPass::kLight),
    // These fields change no pass. Each change is still answered by a picture, and running the light pass is
    // the cheapest way.
    choice<MEMBER(refresh)>("refresh",
                            "when the picture follows the probe: when a sweep is whole, or with every frame",
                            FirstPass::kLight, kRefreshes),
    choice<MEMBER(deadline.plan)>("deadline.plan",
                                  "where the machine cannot keep up: nothing; hold the rate with a coarser "
                                  "picture while the view moves, "
                                  "then always, then a wider step, then cheaper filters; or only the coarser "
                                  "picture while the view moves",
                                  FirstPass::kLight, kDeadlinePlans),
    row<MEMBER(deadline.rate_hz)>("deadline.rate_hz", "Hz", "pictures a second that the plan holds", 1, 60, 0,
                                  FirstPass::kLight),
};

#undef MEMBER

}  // namespace

std::span<const SceneField> scene_fields() {
  return kFields;
}

const SceneField* find_scene_field(std::string_view name) {
  const auto* found = std::ranges::find(kFields, name, &SceneField::name);
  return found == std::end(kFields) ? nullptr : found;
}

}  // namespace fanlight
