// SPDX-License-Identifier: Apache-2.0
// The renderer as a whole: which passes run for which change, the order of pictures, geometry, correctness.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "proto/model/look.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::renderer_tests {
namespace {

const FanGeometry kGeometry{.columns = 96,
                            .rows = 96,
                            .pixel_width_mm = 1,
                            .pixel_height_mm = 1,
                            .face_column = 47.5,
                            .face_row = 0,
                            .motor_radius_mm = 30};

std::vector<double> even_angles(int frames, double half_deg) {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < frames; ++frame) {
    angles_rad.push_back(radians(half_deg * (2.0 * frame / (frames - 1) - 1)));
  }
  return angles_rad;
}

double plate(const Point& at) {
  return at.y_mm > 50 ? 150 : 5;
}

void load_into(Renderer& renderer, const Volume& volume) {
  ASSERT_TRUE(renderer.load(volume));
}

class RendererTest : public GpuTest {
 protected:
  const std::vector<double> angles_rad_ = even_angles(21, 30);
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(kGeometry, angles_rad_, {64, 64}, scene_, counters_);

  /// The scene with another value of that field, such that the scene stays valid and something is visible.
  static Scene with_another(Scene scene, const SceneField& field) {
    if (field.is_text()) {
      const std::string_view text =
          field.name == "cuts.shapes" ? "balls 6 at 0 40 0" : "30 #000000 0, 90 #ffffff 0.5";
      EXPECT_TRUE(set_field(scene, field, text)) << field.name;
      return scene;
    }
    const double now = field.get(scene);
    // A window a little shorter may have as many samples; at 0 the field that counts them holds.
    if (field.name.ends_with("size_mm") || field.name.ends_with("window_mm")) {
      EXPECT_TRUE(set_field(scene, field, 0)) << field.name;
      return scene;
    }
    const double other = field.step > 0 ? (now > field.minimum ? now - field.step : now + field.step)
                                        : std::clamp(now * 0.9 + 0.05, field.minimum, field.maximum);
    EXPECT_TRUE(set_field(scene, field, other)) << field.name;
    return scene;
  }

  Picture changed(std::uint64_t revision, const Scene& scene) {
    renderer_->show({.revision = revision, .scene = scene});
    return next_picture(*renderer_);
  }
  void load(const Volume& volume) { load_into(*renderer_, volume); }
};

TEST_F(RendererTest, RunsEachPassOnlyForAChangeThatNeedsIt) {
  load(made_volume(kGeometry, angles_rad_, plate));
  std::uint64_t revision = 1;
  const Scene shown = with_another(scene_, *find_scene_field("glass.amount"));  // from opaque it is a cast
  changed(++revision, shown);
  for (const SceneField& field : scene_fields()) {
    const Scene scene = with_another(shown, field);
    const auto pass1_runs = counters_.pass1_runs.value();
    const Picture picture = changed(++revision, scene);
    EXPECT_EQ(counters_.pass1_runs.value() - pass1_runs, field.first_pass <= FirstPass::kCast ? 1U : 0U)
        << field.name;
    const auto ran = [&](Stage stage) { return picture.stamp.stage_ms[static_cast<std::size_t>(stage)] > 0; };
    EXPECT_EQ(ran(Stage::kPrepare), field.first_pass == FirstPass::kPrepare) << field.name;
    EXPECT_EQ(ran(Stage::kCast), field.first_pass <= FirstPass::kCast) << field.name;
    EXPECT_EQ(ran(Stage::kFilter), field.first_pass <= FirstPass::kFilter) << field.name;
    EXPECT_TRUE(ran(Stage::kLight)) << field.name;
    EXPECT_EQ(picture.stamp.scene_revision, revision) << field.name;
    EXPECT_EQ(picture.stamp.pass1_runs, counters_.pass1_runs.value()) << field.name;
    changed(++revision, shown);
  }
}

TEST_F(RendererTest, MovesNothingButTheLightWhenTheLightMoves) {
  load(made_volume(kGeometry, angles_rad_, plate));
  const Picture before = next_picture(*renderer_);
  const auto depths_before = renderer_->read_depth();
  Scene moved = scene_;
  moved.light.right_mm = 60;
  const Picture after = changed(2, moved);
  EXPECT_NE(before.rgba, after.rgba);
  EXPECT_EQ(before.stamp.pass1_runs, after.stamp.pass1_runs);
  EXPECT_EQ(after.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)], 0);
  const auto depths_after = renderer_->read_depth();
  EXPECT_EQ(depths_before->cast_mm, depths_after->cast_mm);
}

TEST_F(RendererTest, GivesARevisionItsPictureEvenWhereNothingChanged) {
  load(made_volume(kGeometry, angles_rad_, plate));
  next_picture(*renderer_);
  EXPECT_EQ(changed(7, scene_).stamp.scene_revision, 7U);
  EXPECT_EQ(counters_.pass1_runs.value(), 1U);
}

TEST_F(RendererTest, HasTwoVolumesInFlightAndKeepsTheirOrder) {
  std::uint64_t shown = 0;
  std::uint64_t loaded = 0;
  bool overlapped = false;
  Picture picture;
  while (shown < 6) {
    ASSERT_TRUE(renderer_->advance());
    // Before collect(): a picture counts as under way until then, also where the GPU finishes it at once.
    if (loaded < 6 && renderer_->wants_volume()) {
      overlapped |= renderer_->busy();  // the volume before is still being lit
      Volume volume = made_volume(kGeometry, angles_rad_, plate);
      volume.stamp().volume_id = ++loaded;
      load(volume);
    }
    if (renderer_->collect(picture)) {
      EXPECT_EQ(picture.stamp.volume.volume_id, shown + 1);
      shown = picture.stamp.volume.volume_id;
    }
  }
  EXPECT_TRUE(overlapped);
  EXPECT_EQ(counters_.pass1_runs.value(), 6U);
  EXPECT_EQ(counters_.pictures_finished.value(), 6U);
}

TEST_F(RendererTest, ReadsAForwardAndABackwardSweepAlike) {
  load(made_volume(kGeometry, angles_rad_, plate));
  const Picture forward = next_picture(*renderer_);
  std::vector<double> backward_rad = angles_rad_;
  std::ranges::reverse(backward_rad);
  load(made_volume(kGeometry, backward_rad, plate));
  EXPECT_EQ(next_picture(*renderer_).rgba, forward.rgba);
}

/// Position of a ball in the picture, as fractions of its width and height from the top left.
struct Place {
  double across;
  double down;
};

/// A fan of frames of one kind, swept in one direction.
struct Sweep {
  const char* name;
  FanGeometry geometry;
  bool backward;
};

void PrintTo(const Sweep& sweep, std::ostream* out) {
  *out << sweep.name;
}

constexpr FanGeometry kConvexLines{.kind = FrameKind::kConvexLines,
                                   .columns = 91,
                                   .rows = 96,
                                   .pixel_height_mm = 1,
                                   .face_column = 45,
                                   .face_row = 0,
                                   .motor_radius_mm = 30,
                                   .probe_radius_mm = 40,
                                   .line_pitch_deg = 0.8};
constexpr FanGeometry kLinearLines{.kind = FrameKind::kLinearLines,
                                   .columns = 96,
                                   .rows = 190,
                                   .pixel_width_mm = 1,
                                   .pixel_height_mm = 0.5,
                                   .face_column = 47.5,
                                   .face_row = 0,
                                   .motor_radius_mm = 30};

/// Centre of the pixels that are not black, 0 to 1 along each axis.
struct Middle {
  double across = 0;
  double down = 0;
  double pixels = 0;
};

Middle middle_of_lit(const Picture& picture) {
  Middle middle;
  for (std::uint32_t row = 0; row < picture.height; ++row) {
    for (std::uint32_t column = 0; column < picture.width; ++column) {
      if (picture.rgba[4 * (row * picture.width + column)] == 0) continue;
      middle.across += (column + 0.5) / picture.width;
      middle.down += (row + 0.5) / picture.height;
      middle.pixels += 1;
    }
  }
  middle.across /= middle.pixels;
  middle.down /= middle.pixels;
  return middle;
}

class HandednessTest : public GpuTest, public testing::WithParamInterface<Sweep> {};

// Fails if any axis of the frames, of the sweep or of the picture is mirrored.
TEST_P(HandednessTest, ShowsEachAxisOnItsOwnSide) {
  const FanGeometry& geometry = GetParam().geometry;
  std::vector<double> angles_rad = even_angles(21, 30);
  if (GetParam().backward) std::ranges::reverse(angles_rad);
  RenderCounters counters;
  struct Aim {
    const char* what;
    Point ball;
    double yaw_deg;
    double pitch_deg;
    double roll_deg;
    Place expected;
  };
  // From behind the probe: the marked side (+x) is right, elevation (+z) is up. A camera that moves
  // towards the marked side (yaw) shows deeper points further right; one that moves up shows them further up.
  // A camera that turns clockwise turns the picture anticlockwise.
  const Aim aims[] = {{"+x is right", {25, 50, 0}, 0, 0, 0, {0.75, 0.5}},
                      {"-x is left", {-25, 50, 0}, 0, 0, 0, {0.25, 0.5}},
                      {"+z is up", {0, 50, 25}, 0, 0, 0, {0.5, 0.25}},
                      {"-z is down", {0, 50, -25}, 0, 0, 0, {0.5, 0.75}},
                      {"yaw shows depth to the right", {0, 75, 0}, 30, 0, 0, {0.625, 0.5}},
                      {"pitch shows depth above", {0, 75, 0}, 0, 30, 0, {0.5, 0.375}},
                      {"a clockwise camera turns +x up", {25, 50, 0}, 0, 0, 90, {0.5, 0.25}}};
  for (const Aim& aim : aims) {
    Scene scene = scene_for(geometry, radians(-30), radians(30));
    scene.camera = {.target = {0, 50, 0},
                    .yaw_deg = aim.yaw_deg,
                    .pitch_deg = aim.pitch_deg,
                    .roll_deg = aim.roll_deg,
                    .distance_mm = 50,
                    .field_mm = 100};
    scene.rays.end_mm = 150;
    scene.light.haze = 0;
    const auto renderer = made_renderer(geometry, angles_rad, {64, 64}, scene, counters);
    ASSERT_TRUE(renderer->load(made_volume(geometry, angles_rad, [&](const Point& at) {
      const double from_mm =
          std::hypot(at.x_mm - aim.ball.x_mm, at.y_mm - aim.ball.y_mm, at.z_mm - aim.ball.z_mm);
      return from_mm < 7 ? 200 : 0;
    })));
    const Middle middle = middle_of_lit(next_picture(*renderer));
    ASSERT_GT(middle.pixels, 20) << aim.what << ": the ball is not in the picture";
    EXPECT_NEAR(middle.across, aim.expected.across, 0.05) << aim.what;
    EXPECT_NEAR(middle.down, aim.expected.down, 0.05) << aim.what;
  }
}

// The eye of this camera lies in the probe face, 50 mm in front of the target, where the picture is 100 mm
// high: a point (x, y, z) appears at x * 50 / y to the right and z * 50 / y up.
TEST_P(HandednessTest, ShowsPerspectiveWhereAPinholeWould) {
  const FanGeometry& geometry = GetParam().geometry;
  std::vector<double> angles_rad = even_angles(21, 30);
  if (GetParam().backward) std::ranges::reverse(angles_rad);
  RenderCounters counters;
  for (const Point ball : {Point{20, 80, 10}, Point{-15, 40, -12}, Point{0, 60, 25}}) {
    Scene scene = scene_for(geometry, radians(-30), radians(30));
    scene.camera = {.target = {0, 50, 0},
                    .distance_mm = 50,
                    .field_mm = 100,
                    .projection = Projection::kPerspective,
                    .opening_deg = 90};
    scene.rays.end_mm = 150;
    scene.light.haze = 0;
    const auto renderer = made_renderer(geometry, angles_rad, {64, 64}, scene, counters);
    load_into(*renderer, made_volume(geometry, angles_rad, [&](const Point& at) {
      return std::hypot(at.x_mm - ball.x_mm, at.y_mm - ball.y_mm, at.z_mm - ball.z_mm) < 6 ? 200 : 0;
    }));
    const Middle middle = middle_of_lit(next_picture(*renderer));
    ASSERT_GT(middle.pixels, 10) << "the ball is not in the picture";
    EXPECT_NEAR(middle.across, 0.5 + ball.x_mm * 50 / ball.y_mm / 100, 0.03);
    EXPECT_NEAR(middle.down, 0.5 - ball.z_mm * 50 / ball.y_mm / 100, 0.03);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Sweeps, HandednessTest,
    testing::Values(Sweep{"CartesianForward", kGeometry, false}, Sweep{"CartesianBackward", kGeometry, true},
                    Sweep{"ConvexForward", kConvexLines, false}, Sweep{"ConvexBackward", kConvexLines, true},
                    Sweep{"LinearForward", kLinearLines, false}, Sweep{"LinearBackward", kLinearLines, true}),
    [](const auto& given) { return std::string(given.param.name); });

TEST_F(RendererTest, CastsShadowsAwayFromTheLight) {
  // A post on a plate casts its shadow away from the light.
  load(made_volume(kGeometry, angles_rad_, [](const Point& at) {
    return plate(at) + (std::hypot(at.x_mm, at.z_mm) < 4 && at.y_mm > 30 ? 150 : 0);
  }));
  Scene scene = scene_;
  scene.camera.field_mm = 60;
  scene.filter.size = 1;
  scene.filter.size_mm = 0;
  // Without light that scatters into the shadow.
  ASSERT_TRUE(apply_look(scene, "paper"));
  scene.shadow.coefficient = 0;
  scene.finish.smoothing = Smoothing::kNone;
  scene.light = {.right_mm = -60, .up_mm = 0, .depth_mm = 0, .ambient = 0, .diffuse = 1, .specular = 0};
  const Picture picture = changed(2, scene);
  const auto brightness = [&](int right_mm) {
    const std::size_t column = static_cast<std::size_t>((right_mm / 60.0 + 0.5) * picture.width);
    return picture.rgba[4 * (picture.height / 2 * picture.width + column)];
  };
  EXPECT_GT(brightness(-12), 60);
  EXPECT_EQ(brightness(12), 0);
}

TEST_F(RendererTest, HasNoSurfaceAtTheEdgeOfTheFan) {
  // Bright tissue everywhere: only the border of the scanned region is a step from dark to bright.
  load(made_volume(kGeometry, angles_rad_, [](const Point&) { return 180; }));
  next_picture(*renderer_);
  for (const double yaw_deg : {0.0, 50.0}) {
    Scene scene = scene_;
    scene.camera.yaw_deg = yaw_deg;
    changed(static_cast<std::uint64_t>(yaw_deg) + 2, scene);
    const auto depths = renderer_->read_depth();
    EXPECT_TRUE(std::ranges::all_of(depths->cast_mm, [](float depth) { return depth < 0; }))
        << "yaw " << yaw_deg;
  }
}

TEST_F(RendererTest, HasNoSurfaceAtTheEdgeOfASectorThatTheSpeckleFilterBlurs) {
  // Bright tissue up to the border of the sector, and black outside, which each filter mixes inwards.
  FanGeometry sector = kGeometry;
  sector.probe_radius_mm = 40;
  sector.sector = {.half_angle_deg = 28, .reach_mm = 130};
  const auto tissue = [&](const Point& at) {
    const double depth_mm = std::hypot(at.z_mm, at.y_mm + sector.motor_radius_mm) - sector.motor_radius_mm;
    const double from_apex_mm = std::hypot(at.x_mm, depth_mm + sector.probe_radius_mm);
    const double aside_deg = degrees(std::atan2(std::abs(at.x_mm), depth_mm + sector.probe_radius_mm));
    return aside_deg <= 28 && from_apex_mm >= 40 && from_apex_mm <= 130 ? 180 : 0;
  };
  for (const auto filter : {SpeckleFilter::kBox, SpeckleFilter::kMedian, SpeckleFilter::kGuided}) {
    Scene scene = scene_for(sector, angles_rad_.front(), angles_rad_.back());
    scene.camera.yaw_deg = 50;  // rays enter through the sector's side
    scene.speckle = {.filter = filter, .size = 7, .across = 1, .noise = 0.1};
    scene.filter.size = scene.filter.islands = scene.filter.holes = 1;
    scene.filter.size_mm = 0;
    const auto renderer = made_renderer(sector, angles_rad_, {64, 64}, scene, counters_);
    load_into(*renderer, made_volume(sector, angles_rad_, tissue));
    next_picture(*renderer);
    const auto depths = renderer->read_depth();
    EXPECT_TRUE(std::ranges::all_of(depths->cast_mm, [](float depth) { return depth < 0; }))
        << "filter " << static_cast<int>(filter);
  }
}

TEST_F(RendererTest, TakesTheLargestPicture) {
  Scene scene = scene_;
  scene.rays.step_mm = 4;
  scene.detector = {.window = 4};
  const auto renderer = made_renderer(kGeometry, angles_rad_, {2048, 2048}, scene, counters_);
  load_into(*renderer, made_volume(kGeometry, angles_rad_, plate));
  EXPECT_EQ(next_picture(*renderer).rgba.size(), std::size_t{4} * 2048 * 2048);
}

TEST_F(RendererTest, GivesUpACastForAViewThatNobodyWantsAnyMoreOnce) {
  load(made_volume(kGeometry, angles_rad_, plate));
  next_picture(*renderer_);
  Scene scene = scene_;
  scene.rays.step_mm = 0.02;  // many bands
  renderer_->show({.revision = 2, .scene = scene});
  // A camera that never rests: each cast is given up once, and the next cast gives a picture.
  Picture picture;
  std::uint64_t revision = 2;
  const auto casts = counters_.pass1_runs.value();
  while (!renderer_->collect(picture)) {
    scene.camera.yaw_deg = 0.1 * static_cast<double>(revision);
    renderer_->show({.revision = ++revision, .scene = scene});
    ASSERT_TRUE(renderer_->advance());
    ASSERT_TRUE(renderer_->wait(1'000'000'000));
  }
  EXPECT_EQ(counters_.pass1_runs.value() - casts, 2U);
  EXPECT_LT(picture.stamp.scene_revision, revision);
}

TEST_F(RendererTest, TakesAViewThatMissesTheFan) {
  load(made_volume(kGeometry, angles_rad_, plate));
  next_picture(*renderer_);
  Scene scene = scene_;
  scene.camera.target = {900, 900, 900};
  const Picture picture = changed(2, scene);
  // The haze of the default look everywhere.
  for (std::size_t value = 0; value < picture.rgba.size(); ++value) {
    ASSERT_EQ(picture.rgba[value], picture.rgba[value % 4]) << "at " << value;
  }
  EXPECT_NEAR(picture.rgba[0], 20, 2);
  EXPECT_LT(picture.rgba[1], picture.rgba[0]);
}

TEST_F(RendererTest, SeesNothingOfAnOlderAndLongerSweep) {
  // Bright frames fill the texture. A sweep of fewer, dark frames must not read the remaining bright ones.
  load(made_volume(kGeometry, angles_rad_, [](const Point&) { return 255; }));
  next_picture(*renderer_);
  load(made_volume(kGeometry, angles_rad_, [](const Point&) { return 255; }));
  next_picture(*renderer_);
  Scene volume_scene = scene_;
  volume_scene.mode = Mode::kVolume;
  volume_scene.transfer = TransferFunction::parse("0 #000000 0, 1 #ffffff 0.5").value();
  renderer_->show({.revision = 2, .scene = volume_scene});
  const std::vector<double> fewer_rad(angles_rad_.begin(), angles_rad_.begin() + 11);
  load(made_volume(kGeometry, fewer_rad, [](const Point&) { return 0; }));
  Picture picture = next_picture(*renderer_);
  while (picture.stamp.volume.frames != fewer_rad.size()) picture = next_picture(*renderer_);
  for (std::size_t value = 0; value < picture.rgba.size(); ++value) {
    ASSERT_EQ(picture.rgba[value], value % 4 == 3 ? 255 : 0) << "at " << value;
  }
}

TEST_F(RendererTest, FiltersSpeckleOfALargeVolumePieceByPiece) {
  // 16 frames of this size fill the filter's memory, so one piece ends between frames 12 and 19.
  const FanGeometry large{.columns = 1024,
                          .rows = 1024,
                          .pixel_width_mm = 0.1,
                          .pixel_height_mm = 0.1,
                          .face_column = 511.5,
                          .face_row = 0,
                          .motor_radius_mm = 30};
  std::vector<double> angles_rad = even_angles(20, 19);
  const auto noise = [](const Point& at) {
    return 128 + 100 * std::sin(37 * at.x_mm + 91 * at.y_mm + 53 * at.z_mm);
  };
  Scene scene = scene_for(large, angles_rad.front(), angles_rad.back());
  scene.mode = Mode::kSlices;
  scene.speckle = {.filter = SpeckleFilter::kGuided, .size = 3, .across = 3, .noise = 0.3};
  const PictureSize size{256, 256};
  const auto shown = [&](std::span<const double> frames_rad) {
    const auto renderer = made_renderer(large, frames_rad, size, scene, counters_);
    load_into(*renderer, made_volume(large, frames_rad, noise));
    return next_picture(*renderer);
  };
  const Picture whole = shown(angles_rad);
  const Picture part = shown(std::span(angles_rad).subspan(11, 9));
  EXPECT_EQ(counters_.volumes_unfiltered.value(), 0U);
  // The upper right quarter is the plane through the middle of all frames, +z to the right and +y down. Frame
  // 11 has no neighbour below in the part, so frames from 13 on are filtered alike.
  std::size_t compared = 0;
  for (std::uint32_t row = 0; row < size.height / 2; ++row) {
    for (std::uint32_t column = size.width / 2; column < size.width; ++column) {
      const double pixel = scene.camera.field_mm / (size.height / 2.0);
      const double z_mm = scene.camera.target.z_mm + (column - 128 - 63.5) * pixel;
      const double y_mm = scene.camera.target.y_mm + (row - 63.5) * pixel;
      const double angle_rad = large.fan_coordinate(y_mm, z_mm).angle_rad;
      if (angle_rad < angles_rad[14] || angle_rad > angles_rad[18]) continue;
      ++compared;
      EXPECT_NEAR(whole.rgba[4 * (row * size.width + column)], part.rgba[4 * (row * size.width + column)], 1)
          << column << ", " << row;
    }
  }
  EXPECT_GT(compared, 1000U);
}

TEST_F(RendererTest, RefusesAPictureThatIsTooLarge) {
  const auto refused =
      Renderer::create({.size = {100'000, 100'000},
                        .geometry = kGeometry,
                        .first_angle_rad = -0.5,
                        .last_angle_rad = 0.5,
                        .frame_capacity = 4},
                       {.gpu = gpu(), .counters = counters_}, {.revision = 1, .scene = scene_});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("expected"), std::string::npos);
}

}  // namespace
}  // namespace fanlight::test::renderer_tests
