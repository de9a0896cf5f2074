// SPDX-License-Identifier: Apache-2.0
// Where points of measurements are drawn, in the units of what is drawn over the picture: kDrawnHeight high.
import type { View } from "../../generated/fanlight_pb.js";
import { pixelIn, planeAt, type BodyPoint, type ShownPlane } from "../shown_planes";
import { surfacePart, type PagePoint, type Size } from "../view_geometry";
import type { Mm } from "./figures";
import type { Measurement } from "./measurement_list";
import { kDrawnHeight, pixelOfPoint } from "./surface_path";

const kInPlaneMm = 0.3; // a point so near to a plane is drawn in it

/** Where a point is drawn; undefined: it is not seen. */
export type Places = (point: Mm) => PagePoint | undefined;

/** `height`: of the picture, pixels. */
export function drawnAt({ x, y }: PagePoint, height: number): PagePoint {
  const factor = kDrawnHeight / height;
  return { x: factor * x, y: factor * y };
}

export function placesIn(plane: ShownPlane, height: number): Places {
  return ([x, y, z]) => {
    const { pixel, asideMm } = pixelIn({ x, y, z }, plane);
    const isSeen = asideMm <= kInPlaneMm && planeAt(pixel, [plane]) !== undefined;
    return isSeen ? drawnAt(pixel, height) : undefined;
  };
}

/** In the plane that shows all points of a measurement; the one in which it was taken comes first. */
export function planePlaces(
  { points, place }: Measurement,
  planes: readonly ShownPlane[],
  height: number,
): Places | undefined {
  const holding = planes.filter((plane) => points.every((point) => placesIn(plane, height)(point)));
  const shown = holding.find(({ name }) => place === `in ${name}`) ?? holding[0];
  return shown && placesIn(shown, height);
}

/** On the surface. `full`: size of the picture. */
export function surfacePlaces(mode: string, full: Size, view: View | undefined): Places | undefined {
  const part = surfacePart(mode, full);
  if (!part || !view) return undefined;
  return (point) => {
    const pixel = pixelOfPoint(point, view);
    if (!pixel || pixel.x < part.left || pixel.y < part.top) return undefined;
    if (pixel.x >= part.left + part.width || pixel.y >= part.top + part.height) return undefined;
    // A pixel is drawn at its middle.
    return drawnAt({ x: pixel.x + 0.5, y: pixel.y + 0.5 }, full.height || 1);
  };
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
