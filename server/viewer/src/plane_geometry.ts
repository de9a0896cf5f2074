// SPDX-License-Identifier: Apache-2.0
// The three planes of the four panes, and the crop box, in pixels of the picture. The panes are laid out as
// set_slices() in renderer/parameters/cast_parameters.cpp does; x, y and z are the axes of the transducer
// frame, or those of planes that are turned from them (plane_turn.ts).
import { tidy, type PagePoint, type Rectangle, type Size } from "./view_geometry";

export type Axis = "x" | "y" | "z";
export type Place = Record<Axis, number>;

/** A pane shows the plane through the target at right angles to `fixed`. */
export interface Pane {
  name: "A" | "B" | "C";
  part: Rectangle;
  fixed: Axis;
  right: Axis;
  /** Upwards in the pane is this direction of the axis. */
  up: { axis: Axis; sign: 1 | -1 };
}

/** The fields of the crop box: its low and its high side along each axis. */
export const kCropFields: Record<Axis, readonly [low: string, high: string]> = {
  x: ["crop.left_mm", "crop.right_mm"],
  y: ["crop.near_mm", "crop.far_mm"],
  z: ["crop.below_mm", "crop.above_mm"],
};

/** "Left side of the crop box", of crop.left_mm */
export function sideText(name: string): string {
  const side = name.replace(/^crop\.|_mm$/g, "");
  return `${side[0]!.toUpperCase()}${side.slice(1)} side of the crop box`;
}

/** The plane at right angles to an axis. */
export const kPlaneOf: Record<Axis, Pane["name"]> = { x: "B", y: "C", z: "A" };

const kTickPixels = 36; // least distance of two ticks
const kTicksMm = [1, 2, 5, 10, 20, 50, 100];

export function panesOf(mode: string, { width, height }: Size): Pane[] {
  if (mode !== "slices") return [];
  const left = Math.floor(width / 2);
  const top = Math.floor(height / 2);
  return [
    {
      name: "A",
      part: { left: 0, top: 0, width: left, height: top },
      fixed: "z",
      right: "x",
      up: { axis: "y", sign: -1 },
    },
    {
      name: "B",
      part: { left, top: 0, width: width - left, height: top },
      fixed: "x",
      right: "z",
      up: { axis: "y", sign: -1 },
    },
    {
      name: "C",
      part: { left: 0, top, width: left, height: height - top },
      fixed: "y",
      right: "x",
      up: { axis: "z", sign: 1 },
    },
  ];
}

/** Where a value of an axis lies in the pane: a column for its right axis, a row for its up axis. */
export function pixelAlong(pane: Pane, axis: Axis, value: number, target: Place, fieldMm: number): number {
  const { part, right, up } = pane;
  const pixels = ((value - target[axis]) * part.height) / fieldMm;
  return axis === right ? part.left + part.width / 2 + pixels : part.top + part.height / 2 - up.sign * pixels;
}

/** The inverse of pixelAlong(). */
export function valueAlong(pane: Pane, axis: Axis, pixel: number, target: Place, fieldMm: number): number {
  const { part, right, up } = pane;
  const mmPerPixel = fieldMm / part.height;
  const mm =
    axis === right
      ? (pixel - part.left - part.width / 2) * mmPerPixel
      : up.sign * (part.top + part.height / 2 - pixel) * mmPerPixel;
  return tidy(target[axis] + mm);
}

/** A pixel, no further out than the pane's border, so that an open side of the crop box can be taken there. */
export function withinPane({ part }: Pane, isColumn: boolean, pixel: number): number {
  const [low, size] = isColumn ? [part.left, part.width] : [part.top, part.height];
  return Math.min(low + size - 2, Math.max(low + 2, pixel));
}

/** Rows of the ticks of a depth scale, with their depths in mm from the probe's face; for panes that show the depth. */
export function depthTicks(pane: Pane, target: Place, fieldMm: number): { row: number; depthMm: number }[] {
  if (pane.up.axis !== "y") return [];
  const pixelsPerMm = pane.part.height / fieldMm;
  const step = kTicksMm.find((mm) => mm * pixelsPerMm >= kTickPixels) ?? kTicksMm.at(-1)!;
  const first = Math.max(0, Math.ceil((target.y - fieldMm / 2) / step));
  const last = Math.floor((target.y + fieldMm / 2) / step);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, index) => {
    const depthMm = (first + index) * step;
    return { row: pixelAlong(pane, "y", depthMm, target, fieldMm), depthMm };
  });
}

/** The crop box as far as it is near the target: an open side is drawn at the edge of the field. */
export function boxNear(
  target: Place,
  fieldMm: number,
  side: (field: string) => number,
): Record<Axis, [number, number]> {
  const reach = 0.48 * fieldMm;
  const along = (axis: Axis): [number, number] => {
    const [low, high] = kCropFields[axis].map(side) as [number, number];
    const within = (value: number) => Math.min(target[axis] + reach, Math.max(target[axis] - reach, value));
    return [within(low), within(high)];
  };
  return { x: along("x"), y: along("y"), z: along("z") };
}

/** How far a drag moves a face along its axis: `perMm` is the way of the face's middle in pixels for 1 mm. */
export function alongAxisMm(drag: PagePoint, perMm: PagePoint): number {
  const square = perMm.x ** 2 + perMm.y ** 2;
  return square > 0 ? (drag.x * perMm.x + drag.y * perMm.y) / square : 0;
}

/** A line across the whole pane, as an SVG path. */
export function lineIn({ part }: Pane, isColumn: boolean, at: number): string {
  return isColumn ? `M${at} ${part.top}v${part.height}` : `M${part.left} ${at}h${part.width}`;
}

/** A short bar about the middle of the pane, as an SVG path. */
export function barIn({ part }: Pane, row: number): string {
  const half = part.width / 12;
  return `M${part.left + part.width / 2 - half} ${row}h${2 * half}`;
}
