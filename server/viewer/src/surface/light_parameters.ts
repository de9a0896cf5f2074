// SPDX-License-Identifier: Apache-2.0
// A scene as the uniforms of passes 2 and 3 (shaders/light_parameters.h), as light_parameters() in renderer/parameters
// for the part of the picture that the surface covers.
import type { View } from "../../generated/fanlight_pb.js";
import { kLamps } from "../lamps";
import type { Rectangle } from "../view_geometry";
import { colourMapPoints } from "./colour_maps";

/** The values of a scene by the names of its fields. */
export interface SceneValues {
  number(name: string): number;
  choice(name: string): string;
}

/** Values by the name of a member of LightParameters. */
export type LightParameters = Record<string, number | readonly number[]>;

/** Which constants the shaders have, and which of them run. */
export interface LightPlan {
  parameters: LightParameters;
  perspective: boolean;
  softShadows: boolean;
  softLight: boolean;
  scatters: boolean;
  outlines: boolean;
  diffusionSteps: number;
}

const kShowSurface = 0;
const kShowDepth = 1;
const kScatteredShare = [0.9, 0.6, 0.45];
const kGlowReach = 2;
const kScatterReach = 2.3;
const kMostPlaces = 48;
const kGreyLevels = 255;

/** Linear components of a displayed colour (sRGB). */
function linear(scene: SceneValues, group: string): number[] {
  return ["red", "green", "blue"].map((name) => {
    const value = scene.number(`${group}.${name}`);
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  });
}

/** `view`: of the picture; `part`: of it, with the surface. */
export function lightPlan(scene: SceneValues, view: View, part: Rectangle, asDepth: boolean): LightPlan {
  const scatterMm = scene.number("material.scatter_mm");
  const softLight =
    !asDepth && (scatterMm > 0 || scene.number("light.occlusion") > 0 || scene.number("light.fade_mm") > 0);
  return {
    parameters: {
      ...viewParameters(scene, view, part),
      ...lightParameters(scene),
      ...(softLight ? softParameters(scene, scatterMm, pixelMm(scene, view)) : {}),
      ...finishParameters(scene, asDepth),
    },
    perspective: view.mmPerPixelPerMm > 0,
    softShadows: scene.number("shadow.softness_mm") > 0,
    softLight,
    scatters: softLight && scatterMm > 0,
    outlines: scene.number("finish.outline") > 0,
    diffusionSteps: scene.choice("finish.smoothing") === "diffusion" ? scene.number("finish.iterations") : 0,
  };
}

/** Side of a pixel in the body at the depth of the target. */
function pixelMm(scene: SceneValues, view: View): number {
  return view.mmPerPixel + view.mmPerPixelPerMm * scene.number("camera.distance_mm");
}

function viewParameters(scene: SceneValues, view: View, part: Rectangle): LightParameters {
  const pixel = pixelMm(scene, view);
  const widens = view.mmPerPixelPerMm > 0;
  const eyeHeightMm = widens ? view.mmPerPixel / view.mmPerPixelPerMm : 0;
  const startMm = scene.number("rays.start_mm");
  return {
    width: part.width,
    height: part.height,
    view_left: 0,
    view_top: 0,
    view_right: part.width - 1,
    view_bottom: part.height - 1,
    centre: [view.middleColumn - part.left, view.middleRow - part.top],
    pixel,
    view_scale_at_0: view.mmPerPixel / pixel,
    view_scale_per_mm: view.mmPerPixelPerMm / pixel,
    eye_height: eyeHeightMm,
    // At least 1 mm in front of the eye.
    shadow_top: -(widens ? Math.max(startMm, 1 - eyeHeightMm) : startMm),
    same_surface: scene.number("filter.step_mm"),
  };
}

/** The lights that are on, first the key light. */
function lampParameters(scene: SceneValues): LightParameters {
  const isOn = (group: string) => scene.choice(`${group}.on`) === "on" && scene.number(`${group}.strength`) > 0;
  const lamps = kLamps.filter(isOn).map((group) => {
    const place = (name: string) => scene.number(`${group}.${name}_mm`);
    const fromTarget = [place("right"), place("up"), scene.number("camera.distance_mm") - place("depth")];
    const distanceMm = Math.hypot(...fromTarget);
    return {
      place: [place("right"), place("up"), -place("depth")],
      direction: distanceMm > 0 ? fromTarget.map((each) => each / distanceMm) : [0, 0, 1],
      distance: Math.max(distanceMm, 1e-3),
      colour: linear(scene, group).map((part) => scene.number(`${group}.strength`) * part),
    };
  });
  // WebGL takes no empty arrays.
  const off = { place: [0, 0, 0], direction: [0, 0, 1], distance: 1, colour: [0, 0, 0] };
  const all = kLamps.map((_, index) => lamps[index] ?? off);
  return {
    lamps: lamps.length,
    lamp_places: all.flatMap(({ place }) => place),
    lamp_directions: all.flatMap(({ direction }) => direction),
    lamp_colours: all.flatMap(({ colour }) => colour),
    lamp_distances: all.map(({ distance }) => distance),
  };
}

function lightParameters(scene: SceneValues): LightParameters {
  const halfMm = scene.number("light.half_mm");
  const material = linear(scene, "material");
  return {
    ...lampParameters(scene),
    directional: scene.choice("light.kind") === "directional" ? 1 : 0,
    light_colour: linear(scene, "light"),
    material,
    ambient: scene.number("light.ambient"),
    diffuse: scene.number("light.diffuse"),
    specular: scene.number("light.specular"),
    shininess: scene.number("light.shininess"),
    central_normals: scene.choice("light.normals") === "central" ? 1 : 0,
    shadow: scene.number("shadow.coefficient"),
    softness: scene.number("shadow.softness_mm"),
    rim: scene.number("light.rim"),
    half_from: scene.number("camera.distance_mm"),
    halves_per_mm: halfMm > 0 ? 1 / halfMm : 0,
    haze: linear(scene, "light").map((part, index) => scene.number("light.haze") * part * material[index]!),
  };
}

function softParameters(scene: SceneValues, scatterMm: number, pixel: number): LightParameters {
  const parameters = {
    occlusion: scene.number("light.occlusion"),
    occlusion_reach: scene.number("light.occlusion_mm"),
    fade_reach: scene.number("light.fade_mm"),
  };
  if (scatterMm <= 0) return parameters;
  return {
    ...parameters,
    scattered: kScatteredShare,
    scatter_radius: Math.ceil(Math.min((kScatterReach * scatterMm) / (2 * pixel), kMostPlaces)),
    scatter_fall: 1 / (2 * scatterMm * scatterMm),
    glow: scene.number("material.glow"),
    glow_reach: kGlowReach * scatterMm,
  };
}

/** As set_outline() in renderer/parameters/light_parameters.cpp. */
function outlineParameters(radius: number): LightParameters {
  const fall = 1 / (radius + 1) ** 2;
  let [middle, offsets] = [0, 0];
  for (let row = -radius; row <= radius; ++row) {
    for (let column = 0; column <= radius; ++column) {
      const weight = Math.max(1 - fall * (row * row + column * column), 0);
      if (column === 0) middle += weight;
      offsets += weight * column;
    }
  }
  return { outline_radius: radius, outline_fall: fall, outline_scale: offsets / middle };
}

function finishParameters(scene: SceneValues, asDepth: boolean): LightParameters {
  const colours = scene.choice("finish.colours");
  const outline = scene.number("finish.outline");
  const startMm = scene.number("rays.start_mm");
  return {
    exposure: scene.number("finish.exposure"),
    film: scene.choice("finish.tone") === "film" ? 1 : 0,
    show: asDepth ? kShowDepth : kShowSurface,
    depth_white: startMm,
    depth_scale: 1 / (scene.number("rays.end_mm") - startMm),
    ...outlineParameters(outline),
    mean: scene.choice("finish.smoothing") === "mean" ? 1 : 0,
    diffusion_scale: kGreyLevels / scene.number("finish.conductance"),
    map_colours: colours === "none" ? 0 : 1,
    map_points: colourMapPoints(colours),
  };
}
