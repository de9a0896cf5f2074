// SPDX-License-Identifier: Apache-2.0
// The cost of what a scene adds to the picture, beside the same picture without it, in one run: the lights in
// the stage "light", smooth outlines in the stage "finish", cuts in the stage "cast".
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>

#include "tests/bench/still_renderer.hpp"

namespace fanlight {
namespace {

struct Variant {
  std::string name;
  Stage stage = Stage::kLight;
  Scene scene;
  std::vector<double> ms;
};

/// A lasso seen from the probe: a circle about a point of the x-z plane, cut through to a depth.
std::string lasso(double x_mm, double z_mm, double radius_mm, double far_mm) {
  constexpr int kCorners = 40;
  std::string text = fmt::format("inside -3000 {} from 0 0 0 right 1 0 0 up 0 0 1 eye 0 outline", far_mm);
  for (int corner = 0; corner < kCorners; ++corner) {
    const double angle = 2 * std::numbers::pi * corner / kCorners;
    text +=
        fmt::format(" {:.2f} {:.2f}", x_mm + radius_mm * std::cos(angle), z_mm + radius_mm * std::sin(angle));
  }
  return text;
}

std::vector<Variant> variants(const Scene& scene) {
  std::vector<Variant> made;
  const auto add = [&](std::string name, Stage stage, auto change) {
    made.push_back({.name = std::move(name), .stage = stage, .scene = scene, .ms = {}});
    change(made.back().scene);
  };
  const auto lights = [](int count) {
    return [count](Scene& to) {
      to.fill_light.on = count > 1 ? LightSwitch::kOn : LightSwitch::kOff;
      to.back_light.on = count > 2 ? LightSwitch::kOn : LightSwitch::kOff;
    };
  };
  const auto cuts = [](const std::string& text) {
    return [text](Scene& to) { to.cuts.shapes = *CutList::parse(text); };
  };
  add("key light", Stage::kLight, lights(1));
  add("key and fill light", Stage::kLight, lights(2));
  add("three lights", Stage::kLight, lights(3));
  add("stairs", Stage::kFinish, [](Scene& to) { to.finish.outline = 0; });
  add("outlines", Stage::kFinish, [](Scene& to) { to.finish.outline = 3; });
  add("no cut", Stage::kCast, [](Scene&) {});
  add("one lasso", Stage::kCast, cuts(lasso(0, 0, 20, 80)));
  std::string eight;
  for (int each = 0; each < 8; ++each) {
    eight +=
        fmt::format("{}{}", each > 0 ? "; " : "", lasso(-40 + 12 * each, 5 * each - 20, 12, 60 + 4 * each));
  }
  add("eight lassos", Stage::kCast, cuts(eight));
  return made;
}

void run(const PhantomSource::Config& config, int rounds) {
  StillRenderer renderer(config);
  std::vector<Variant> all = variants(renderer.scene());
  // One more round than counted: the first one builds pipelines. A moved light or camera makes a stage run.
  for (int round = 0; round <= rounds; ++round) {
    for (Variant& each : all) {
      each.scene.light.right_mm += 0.5;
      if (each.stage == Stage::kCast) each.scene.camera.yaw_deg += 0.5;
      const Picture picture = renderer.show(each.scene);
      if (round > 0) each.ms.push_back(stage_ms(picture, each.stage));
    }
  }
  fmt::print("512 x 512 pixels on {}, medians of {}\n", renderer.device(), rounds);
  double base_ms = 0;
  Stage of = Stage::kPrepare;
  for (const Variant& each : all) {
    const double ms = median(each.ms);
    // The first of a stage is what the others are compared with.
    if (each.stage != of) base_ms = ms;
    of = each.stage;
    fmt::print("{:<8}{:<20}{:>9.2f} ms{:>7.2f}\n", kStageNames[static_cast<std::size_t>(of)], each.name, ms,
               ms / base_ms);
  }
}

}  // namespace
}  // namespace fanlight

int main(int count, char** arguments) {
  int rounds = 15;
  bool womb = false;
  CLI::App program("What lights, smooth outlines and cuts cost");
  program.add_option("--rounds", rounds, "How often each is timed")->check(CLI::Range(1, 1000));
  program.add_flag("--womb", womb, "A fetus in fluid instead of the usual relief");
  CLI11_PARSE(program, count, arguments);
  using fanlight::PhantomSource;
  PhantomSource::Config config;
  if (womb) config.scene = PhantomSource::Scene::kWomb;
  fanlight::run(config, rounds);
  return 0;
}
