// Which settings stand together, in which order and under which title.
import type { SceneField } from "../generated/fanlight_pb.js";
import { groupOf, labelOf } from "./field_text";

/** One row: a field, or three that are one colour. */
export type Setting = { kind: "field"; field: SceneField } | ColourSetting;
export interface ColourSetting {
  kind: "colour";
  name: string; // GROUP.colour, which no field is called
  parts: readonly [red: SceneField, green: SceneField, blue: SceneField];
}

export interface Section {
  /** The prefix of its fields' names; empty for the fields of the first section, which are of several. */
  group: string;
  title: string;
  settings: Setting[];
}

/** The first section, under these names. Beside the mode it has what is reached for most. */
const kMain = new Map([
  ["mode", "Mode"],
  ["slice.depth_mm", "Slice depth"],
  ["detector.threshold", "Threshold"],
  ["filter.size", "Filter size"],
  ["shadow.coefficient", "Shadow coefficient"],
]);

/** From what makes the surface, over how it looks, to what is set once. Others come after these. */
const kGroups = new Map([
  ["detector", "Surface detector"],
  ["speckle", "Speckle reduction"],
  ["filter", "Depth filter"],
  ["light", "Light"],
  ["material", "Surface colour"],
  ["shadow", "Shadow"],
  ["finish", "Finish"],
  ["camera", "Camera"],
  ["rays", "Rays"],
  ["crop", "Crop box"],
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

/** What a field's row is called in its section. */
export function rowTitle(name: string): string {
  return kMain.get(name) ?? labelOf(name);
}

/** What a field is called out of its section: "Clip plane 1, normal x". */
export function fullTitle(name: string): string {
  const group = groupOf(name);
  return group === "" ? labelOf(name) : `${groupTitle(group)}, ${labelOf(name).toLowerCase()}`;
}

/** Three fields in a row that are named red, green and blue are one colour. */
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

/** Sorted as the order names them; what it does not name comes after, as it came. */
function inOrder<T>(items: readonly T[], name: (item: T) => string, order: readonly string[]): T[] {
  const rank = (item: T) => (order.includes(name(item)) ? order.indexOf(name(item)) : order.length);
  return [...items].sort((a, b) => rank(a) - rank(b));
}
