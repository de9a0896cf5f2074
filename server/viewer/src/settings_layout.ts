// SPDX-License-Identifier: Apache-2.0
// Grouping, order and titles of the settings.
import type { SceneField } from "../generated/fanlight_pb.js";
import { groupOf, labelOf } from "./field_text";

/** One row: a field, or three fields that are one colour. */
export type Setting = { kind: "field"; field: SceneField } | ColourSetting;
export interface ColourSetting {
  kind: "colour";
  name: string; // GROUP.colour, a name that no field has
  parts: readonly [red: SceneField, green: SceneField, blue: SceneField];
}

export interface Section {
  /** Prefix of the names of its fields; empty for the first section, which has fields of several groups. */
  group: string;
  title: string;
  settings: Setting[];
}

/** Fields of the first section and their titles: the mode, and the most used ones. */
const kMain = new Map([
  ["mode", "Mode"],
  ["slice.depth_mm", "Slice depth"],
  ["detector.threshold", "Threshold"],
  ["filter.size_mm", "Filter size"],
  ["shadow.coefficient", "Shadow coefficient"],
]);

/** Order: what detects the surface, what it looks like, what is set once. Unknown groups follow. */
const kGroups = new Map([
  ["detector", "Surface detector"],
  ["near", "Near tissue"],
  ["speckle", "Speckle reduction"],
  ["filter", "Depth filter"],
  ["light", "Light"],
  ["fill_light", "Fill light"],
  ["back_light", "Back light"],
  ["material", "Surface colour"],
  ["glass", "Glass"],
  ["shadow", "Shadow"],
  ["finish", "Finish"],
  ["camera", "Camera"],
  ["rays", "Rays"],
  ["crop", "Crop box"],
  ["cuts", "Scalpel"],
  ["clip1", "Clip plane 1"],
  ["clip2", "Clip plane 2"],
  ["transfer", "Volume colours"],
  ["slice", "Slice"],
  ["deadline", "Picture rate"],
]);

export function sections(fields: readonly SceneField[]): Section[] {
  const isMain = (field: SceneField) => kMain.has(field.name) || groupOf(field.name) === "";
  const main = inOrder(fields.filter(isMain), (field) => field.name, [...kMain.keys()]);
  const others = fields.filter((field) => !isMain(field));
  const groups = inOrder([...new Set(others.map((field) => groupOf(field.name)))], (group) => group, [
    ...kGroups.keys(),
  ]);
  return [
    { group: "", title: "Picture", settings: main.map((field) => ({ kind: "field", field })) },
    ...groups.map((group) => ({
      group,
      title: groupTitle(group),
      settings: withColours(others.filter((field) => groupOf(field.name) === group)),
    })),
  ];
}

export function namesOf(setting: Setting): string[] {
  return setting.kind === "colour" ? setting.parts.map((part) => part.name) : [setting.field.name];
}

export function groupTitle(group: string): string {
  return kGroups.get(group) ?? labelOf(group);
}

/** Title of a field within its section. */
export function rowTitle(name: string): string {
  return kMain.get(name) ?? labelOf(name);
}

/** Title of a field outside its section: "Clip plane 1, normal x". */
export function fullTitle(name: string): string {
  const group = groupOf(name);
  return group === "" ? labelOf(name) : `${groupTitle(group)}, ${labelOf(name).toLowerCase()}`;
}

/** Merges three successive fields named red, green and blue into one colour. */
function withColours(fields: readonly SceneField[]): Setting[] {
  const settings: Setting[] = [];
  for (let at = 0; at < fields.length; ++at) {
    const [red, green, blue] = fields.slice(at, at + 3);
    const part = (field: SceneField | undefined, name: string) => field?.name.endsWith(`.${name}`);
    if (red && green && blue && part(red, "red") && part(green, "green") && part(blue, "blue")) {
      settings.push({ kind: "colour", name: `${groupOf(red.name)}.colour`, parts: [red, green, blue] });
      at += 2;
    } else if (red) {
      settings.push({ kind: "field", field: red });
    }
  }
  return settings;
}

/** Sorted by `order`; items that it does not name follow in their present order. */
function inOrder<T>(items: readonly T[], name: (item: T) => string, order: readonly string[]): T[] {
  const rank = (item: T) => (order.includes(name(item)) ? order.indexOf(name(item)) : order.length);
  return [...items].sort((a, b) => rank(a) - rank(b));
}
