// SPDX-License-Identifier: Apache-2.0
// Where points of measurements are drawn, in the units of what is drawn over the picture: kDrawnHeight high.
import type { View } from "../../generated/fanlight_pb.js";
import { pixelIn, planeAt, type BodyPoint, type ShownPlane } from "../shown_planes";
import { surfacePart, type PagePoint, type Size } from "../view_geometry";
import type { Mm } from "./figures";
import type { Measurement } from "./measurement_list";
import { kDrawnHeight, pixelOfPoint } from "./surface_path";

const kBehindMm = 8; // as of notes: deeper below the surface, a point is on its far side
const kInPlaneMm = 0.3; // a point so near to a plane is drawn in it

/** Where a point is drawn; undefined: it is not seen. */
export type Places = (point: Mm) => PagePoint | undefined;

/** A part of the picture that shows a measurement. */
export interface Pane {
  place: Places;
  /** Where it ends at the right, in the units of what is drawn. */
  right: number;
  /** Whether a point is on the far side of what is seen, as far as that is known. */
  isBehind?(point: Mm): boolean;
}

function rightOf({ left, width }: { left: number; width: number }, height: number): number {
  return drawnAt({ x: left + width, y: 0 }, height).x;
}

/** `height`: of the picture, pixels. */
export function drawnAt({ x, y }: PagePoint, height: number): PagePoint {
  const factor = kDrawnHeight / height;
  return { x: factor * x, y: factor * y };
}

export function paneOf(plane: ShownPlane, height: number): Pane {
  const place = ([x, y, z]: Mm) => {
    const { pixel, asideMm } = pixelIn({ x, y, z }, plane);
    const isSeen = asideMm <= kInPlaneMm && planeAt(pixel, [plane]) !== undefined;
    return isSeen ? drawnAt(pixel, height) : undefined;
  };
  return { place, right: rightOf(plane.part, height) };
}

/** In the plane that shows all points of a measurement; the one in which it was taken comes first. */
export function planePane(
  { points, place }: Measurement,
  planes: readonly ShownPlane[],
  height: number,
): Pane | undefined {
  const holding = planes.filter((plane) => points.every((point) => paneOf(plane, height).place(point)));
  const shown = holding.find(({ name }) => place === `in ${name}`) ?? holding[0];
  return shown && paneOf(shown, height);
}

/** On the surface. `full`: size of the picture. `seen`: the point of the body at a pixel, if it is known. */
export function surfacePane(
  mode: string,
  full: Size,
  view: View | undefined,
  seen: (pixel: PagePoint) => Mm | undefined,
): Pane | undefined {
  const part = surfacePart(mode, full);
  if (!part || !view) return undefined;
  const place = (point: Mm) => {
    const pixel = pixelOfPoint(point, view);
    if (!pixel || pixel.x < part.left || pixel.y < part.top) return undefined;
    if (pixel.x >= part.left + part.width || pixel.y >= part.top + part.height) return undefined;
    // A pixel is drawn at its middle.
    return drawnAt({ x: pixel.x + 0.5, y: pixel.y + 0.5 }, full.height || 1);
  };
  const forward = forwardOf(view);
  const isBehind = (point: Mm) => {
    const pixel = pixelOfPoint(point, view);
    const before = pixel && seen(pixel);
    if (!before || !forward) return false;
    return [0, 1, 2].reduce((sum, axis) => sum + forward[axis]! * (point[axis]! - before[axis]!), 0) > kBehindMm;
  };
  return { place, right: rightOf(part, full.height || 1), isBehind };
}

export function mmOf({ x, y, z }: BodyPoint): Mm {
  return [x, y, z];
}

/** Along the view, away from the viewer. */
export function forwardOf(view: View | undefined): Mm | undefined {
  return view?.matrix.length === 16 ? [view.matrix[2]!, view.matrix[6]!, view.matrix[10]!] : undefined;
}

/** The pixel at a place that is given in shares of the picture. */
export function pixelAt({ x, y }: PagePoint, { width, height }: Size): PagePoint {
  const within = (at: number, size: number) => Math.min(size - 1, Math.max(0, Math.floor(at * size)));
  return { x: within(x, width), y: within(y, height) };
}

/** At right angles to the plane. */
export function acrossOf({ right, up }: ShownPlane): Mm {
  return [right.y * up.z - right.z * up.y, right.z * up.x - right.x * up.z, right.x * up.y - right.y * up.x];
}
