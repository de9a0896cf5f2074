// SPDX-License-Identifier: Apache-2.0
// Between pixels of the picture and points of the surface.
import type { View } from "../../generated/fanlight_pb.js";
import type { PagePoint } from "../view_geometry";
import type { Mm } from "./figures";

export const kDrawnHeight = 512; // of the picture, in the units of what is drawn over it
const kPixelsApart = 3; // nearer samples add the depth map's noise to the path
const kMostPoints = 1024; // of a request

/** Pixels from one to the other, both included, about kPixelsApart apart in a picture of the usual height. */
export function pathPixels(from: PagePoint, to: PagePoint, height = kDrawnHeight): PagePoint[] {
  const apart = (kPixelsApart * height) / kDrawnHeight;
  const steps = Math.hypot(to.x - from.x, to.y - from.y) / apart;
  const count = Math.min(kMostPoints - 1, Math.max(1, Math.round(steps)));
  return Array.from({ length: count + 1 }, (_, index) => {
    const share = index / count;
    return { x: Math.round(from.x + share * (to.x - from.x)), y: Math.round(from.y + share * (to.y - from.y)) };
  });
}

/** The pixel, in the size that the view is of, of a point in the transducer frame. */
export function pixelOfPoint([x, y, z]: Mm, view: View): PagePoint | undefined {
  const m = view.matrix;
  if (m.length !== 16) return undefined;
  const from = [x - m[3]!, y - m[7]!, z - m[11]!] as const;
  const along = (column: number) => from[0] * m[column]! + from[1] * m[4 + column]! + from[2] * m[8 + column]!;
  const scale = view.mmPerPixel + along(2) * view.mmPerPixelPerMm;
  if (!(scale > 0)) return undefined;
  return { x: view.middleColumn + along(0) / scale, y: view.middleRow + along(1) / scale };
}
