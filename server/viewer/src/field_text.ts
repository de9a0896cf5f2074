// SPDX-License-Identifier: Apache-2.0
// Texts about a scene field for the user.
import type { SceneField } from "../generated/fanlight_pb.js";
import type { Value } from "./scene";

const kUnitSuffix = /_(mm|deg)$/;

/** "light" for "light.right_mm"; empty for a name without a dot. */
export function groupOf(name: string): string {
  return name.includes(".") ? name.slice(0, name.indexOf(".")) : "";
}

/** "Right" for light.right_mm. */
export function labelOf(name: string): string {
  const words = name
    .slice(name.indexOf(".") + 1)
    .replace(kUnitSuffix, "")
    .replace(/_/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Rounded to a hundredth, or a thousandth below one, without trailing zeros. */
export function numberText(value: number): string {
  if (Number.isNaN(value)) return "";
  return String(Number(value.toFixed(Math.abs(value) < 1 ? 3 : 2)));
}

/** "dark to bright" for dark-to-bright. */
export function choiceText(choice: string): string {
  return choice.replace(/-/g, " ");
}

export function valueText(field: SceneField, value: Value): string {
  if (typeof value === "string") return value;
  const choice = field.choices[value];
  return choice === undefined ? numberText(value) : choiceText(choice);
}

/** "0 to 255 grey levels" */
export function rangeText({ minimum, maximum, unit }: SceneField): string {
  return `${numberText(minimum)} to ${numberText(maximum)}${unit && ` ${unit}`}`;
}

/** "step in the echo that makes a surface; 0 to 255 grey levels, default 40" */
export function hintOf(field: SceneField, defaultValue: Value): string {
  const range = field.isText || field.choices.length > 0 ? "" : `${rangeText(field)}, `;
  return `${field.help}; ${range}default ${valueText(field, defaultValue)}`;
}

/**
 * The part of a field's range that its slider covers. Lengths may be metres, too coarse for a slider: for them it
 * covers twice the height of the default picture. The number box accepts the whole range.
 */
export function sliderRange(field: SceneField, pictureHeightMm: number): { low: number; high: number; step: number } {
  const reach = field.unit === "mm" ? 2 * pictureHeightMm : Infinity;
  const low = Math.max(field.minimum, -reach);
  const high = Math.min(field.maximum, reach);
  if (field.step > 0) return { low, high, step: field.step };
  const step = 10 ** Math.floor(Math.log10((high - low) / 100));
  const decimals = Math.max(0, -Math.log10(step));
  return { low: Number((Math.ceil(low / step) * step).toFixed(decimals)), high, step };
}
