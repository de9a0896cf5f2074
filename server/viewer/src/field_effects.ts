// SPDX-License-Identifier: Apache-2.0
// Which settings have no effect in the present scene, and what they need. A setting that is not in the table always
// has an effect.
import type { SceneField } from "../generated/fanlight_pb.js";
import { choiceText, groupOf, labelOf } from "./field_text";
import type { Lamp } from "./lamps";
import type { SettingsEditor } from "./settings_editor";
import { fullTitle } from "./settings_layout";

/** A choice is compared by name. */
type Condition = readonly [field: string, relation: Relation, ...operands: readonly (string | number)[]];
type Relation = "is" | "is not" | "is above" | "is below";

const kSurfaceShown: Condition = ["mode", "is", "surface", "surface-and-volume", "slices"];
/** Modes that show a surface. */
export const kSurfaceModes = ["surface", "surface-and-volume", "depth", "slices"];
/** What shows the planes A, B and C, or planes parallel to them. */
const kPlanesThatTurn: readonly Condition[] = [["mode", "is", "slices", "tomography"]];
const kDepthShown: Condition = ["mode", "is", ...kSurfaceModes];

/** What needs a light that is on: its place and strength. The colour of the key light is also the ambient one's. */
const kOfLamps = ["right_mm", "up_mm", "depth_mm", "strength"];
const kOfLampsAdded = [...kOfLamps, "red", "green", "blue"];

function whereOn(lamp: Lamp, names: readonly string[]): Record<string, readonly Condition[]> {
  return Object.fromEntries(names.map((name) => [`${lamp}.${name}`, [[`${lamp}.on`, "is", "on"]]]));
}

/** A group or a field has an effect if any of its conditions holds. A field also needs those of its group. */
const kNeeds: Readonly<Record<string, readonly Condition[]>> = {
  detector: [kDepthShown],
  filter: [kDepthShown],
  light: [kSurfaceShown],
  fill_light: [kSurfaceShown],
  back_light: [kSurfaceShown],
  material: [kSurfaceShown],
  shadow: [kSurfaceShown],
  glass: [["mode", "is", "surface", "slices"]],
  rays: [["mode", "is not", "slice", "tomography"]],
  transfer: [["mode", "is", "volume", "surface-and-volume"]],
  slice: [["mode", "is", "slice", "slices", "tomography"]],

  "slice.depth_mm": [["mode", "is", "slice"]],
  "slice.plane": [["mode", "is", "tomography"]],
  "slice.step_mm": [["mode", "is", "tomography"]],
  "slice.yaw_deg": kPlanesThatTurn,
  "slice.pitch_deg": kPlanesThatTurn,
  "slice.roll_deg": kPlanesThatTurn,
  "slice.slab": [["slice.slab_mm", "is above", 0]],
  "near.shift_mm": [
    ["near.tissue", "is", "removed"],
    ["near.before_bone", "is", "removed"],
  ],
  "speckle.size": [["speckle.filter", "is not", "none"]],
  "speckle.size_mm": [["speckle.filter", "is not", "none"]],
  "speckle.across": [["speckle.filter", "is not", "none"]],
  "speckle.noise": [["speckle.filter", "is", "guided"]],
  "speckle.levels": [["speckle.filter", "is", "guided"]],
  "filter.kind": [
    ["filter.size_mm", "is above", 0],
    ["filter.size", "is above", 1],
  ],
  "filter.weights": [
    ["filter.size_mm", "is above", 0],
    ["filter.size", "is above", 1],
  ],
  "filter.steady": [["refresh", "is", "volume"]],
  "filter.seam_frames": [["refresh", "is", "frame"]],
  "filter.step_mm": [
    ["filter.kind", "is", "edge-preserving"],
    ["filter.islands", "is above", 1],
    ["filter.holes", "is above", 1],
    ["filter.steady", "is above", 0],
    ["refresh", "is", "frame"],
    ["light.normals", "is", "central"],
    ["finish.outline", "is above", 0],
  ],
  ...whereOn("light", kOfLamps),
  ...whereOn("fill_light", kOfLampsAdded),
  ...whereOn("back_light", kOfLampsAdded),
  "light.occlusion_mm": [["light.occlusion", "is above", 0]],
  "material.glow": [["material.scatter_mm", "is above", 0]],
  "detector.rise": [["detector.place", "is", "level"]],
  "detector.reach": [["detector.place", "is", "level"]],
  "detector.sheet_below": [["detector.place", "is", "level"]],
  "detector.least_tissue": [["detector.place", "is", "level"]],
  "light.shininess": [["light.specular", "is above", 0]],
  "shadow.softness_mm": [["shadow.coefficient", "is below", 1]],
  "finish.outline": [kDepthShown],
  "finish.iterations": [["finish.smoothing", "is", "diffusion"]],
  "finish.conductance": [["finish.smoothing", "is", "diffusion"]],
  "deadline.rate_hz": [["deadline.plan", "is not", "off"]],
  "camera.opening_deg": [["camera.projection", "is", "perspective"]],
  "clip1.distance_mm": normalGiven("clip1"),
  "clip2.distance_mm": normalGiven("clip2"),
};

export class FieldEffects {
  constructor(private readonly editor: SettingsEditor) {}

  /** The condition that the group or field lacks, as a sentence; undefined if it has an effect. */
  missing(name: string): string | undefined {
    const conditions = kNeeds[name];
    if (!conditions || conditions.some((condition) => this.holds(condition))) return undefined;
    if (conditions.every(([, relation]) => relation === "is not")) {
      const all = conditions.map(([field, , ...operands]) => sentence([field, "is", ...operands], name));
      return `No effect while ${listed(all, "and")}.`;
    }
    return `No effect unless ${listed(conditions.map((condition) => sentence(condition, name)))}.`;
  }

  private holds([field, relation, ...operands]: Condition): boolean {
    const value = this.editor.get(field);
    if (typeof value !== "number") return true; // its value is not known yet
    const choice = this.editor.choice(field);
    const isOne = operands.some((operand) => operand === (typeof operand === "string" ? choice : value));
    switch (relation) {
      case "is":
        return isOne;
      case "is not":
        return !isOne;
      case "is above":
        return value > Number(operands[0]);
      case "is below":
        return value < Number(operands[0]);
    }
  }
}

/** Names in the table that the server does not offer. Any such name is an error in the table. */
export function unknownNames(fields: readonly SceneField[]): string[] {
  const choices = new Map(fields.map((field) => [field.name, field.choices]));
  const known = new Set([...choices.keys(), ...fields.map((field) => groupOf(field.name))]);
  const asked = Object.values(kNeeds).flat();
  return [
    ...[...Object.keys(kNeeds), ...asked.map(([field]) => field)].filter((name) => !known.has(name)),
    ...asked.flatMap(([field, , ...operands]) =>
      operands
        .filter((operand) => typeof operand === "string" && !choices.get(field)?.includes(operand))
        .map((operand) => `${field} ${operand}`),
    ),
  ];
}

function normalGiven(clip: string): Condition[] {
  return ["x", "y", "z"].map((axis) => [`${clip}.normal_${axis}`, "is not", 0] as const);
}

/** "projection is perspective"; the group is left out if `beside` has the same one. */
function sentence([field, relation, ...operands]: Condition, beside: string): string {
  const title = groupOf(field) === groupOf(beside) ? labelOf(field) : fullTitle(field);
  return `${title.toLowerCase()} ${relation} ${listed(operands.map((operand) => choiceText(String(operand))))}`;
}

function listed(words: readonly string[], last = "or"): string {
  return words.length < 2 ? words.join("") : `${words.slice(0, -1).join(", ")} ${last} ${words.at(-1)}`;
}
