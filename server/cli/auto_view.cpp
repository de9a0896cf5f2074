// SPDX-License-Identifier: Apache-2.0
#include "server/cli/auto_view.hpp"

#include <fmt/format.h>
#include <CLI/App.hpp>

#include "renderer/survey/auto_scene.hpp"

namespace fanlight {

Result<AutoView> auto_view(const Volume& volume, const Scene& base, const SceneOptions& given,
                           const PictureSize& size) {
  AutoView view{.scene = base, .choices = {}, .options = {}};
  if (auto found = auto_scene(volume, base, size)) {
    view.scene = found->scene;
    view.choices = std::move(found->choices);
  } else {
    view.scene.mode = Mode::kSlices;
    view.choices = {"no surface stands out of this volume: shows its slices"};
  }
  const auto scene = given.applied_to(view.scene);
  if (!scene) return scene.error();
  view.scene = *scene;
  for (const SceneField& field : scene_fields()) {
    if (field.same(base, view.scene)) continue;
    const auto add = [&](const SceneField& each) {
      view.options +=
          fmt::format("{}--{} {}", view.options.empty() ? "" : " ", each.name, field_text(view.scene, each));
    };
    add(field);
    // A window in samples or pixels sets the one in mm to 0.
    const SceneField* const in_mm = find_scene_field(std::string(field.name) + "_mm");
    if (in_mm != nullptr && in_mm->same(base, view.scene)) add(*in_mm);
  }
  return view;
}

void AutoOptions::add_to(CLI::App& command) {
  auto* const find = command.add_flag(
      "--auto", on,
      "Find the surface in the first volume, and choose camera, rays, detector and light for "
      "it; the default for probes, and for recordings other than those of the simulated probe, if no --mode, "
      "--camera or --rays is given");
  command.add_flag("--no-auto", off, "Look along the depth axis instead, at the whole fan")->excludes(find);
}

bool finds_view(const AutoOptions& asked, const SceneOptions& given, const SourceDescription& source) {
  return asked.on || (!asked.off && !source.simulated && !given.choose_view());
}

}  // namespace fanlight
