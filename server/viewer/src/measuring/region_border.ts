// SPDX-License-Identifier: Apache-2.0
// Where a region of fluid ends in a plane: lines between the places where its depth passes the border's.
import type { FluidRegion } from "../../generated/fanlight_pb.js";
import type { ShownPlane } from "../shown_planes";
import { pixelOf, type PagePoint } from "../view_geometry";
import type { Mm } from "./figures";
import { acrossOf } from "./measured_places";

const kBorder = 128; // FluidRegion.depths
const kMostCells = 48;
const kStepsACell = 1.3; // of the lines
const kMostSteps = 120;

/** A region on a grid: FluidRegion. */
export interface RegionGrid {
  first: Mm;
  stepMm: number;
  size: readonly [number, number, number];
  depths: Uint8Array;
}

/** undefined where the message's numbers contradict each other. */
export function regionGrid(region: FluidRegion): RegionGrid | undefined {
  const { columns, rows, slices, stepMm, depths } = region;
  const isSide = (cells: number) => cells >= 2 && cells <= kMostCells;
  const isGood = [columns, rows, slices].every(isSide) && depths.length === columns * rows * slices && stepMm > 0;
  if (!isGood) return undefined;
  return { first: [region.firstXMm, region.firstYMm, region.firstZMm], stepMm, size: [columns, rows, slices], depths };
}

/** Between the centres of eight cells; 0 outside the grid. */
export function depthAt({ first, stepMm, size, depths }: RegionGrid, at: Mm): number {
  const place = [0, 1, 2].map((axis) => (at[axis]! - first[axis]!) / stepMm);
  if (!place.every((cell, axis) => cell >= 0 && cell <= size[axis]! - 1)) return 0;
  const cell = place.map((where, axis) => Math.min(Math.floor(where), size[axis]! - 2));
  const share = place.map((where, axis) => where - cell[axis]!);
  const strides = [1, size[0], size[0] * size[1]];
  let sum = 0;
  for (let corner = 0; corner < 8; ++corner) {
    let weight = 1;
    let index = 0;
    for (const axis of [0, 1, 2]) {
      const isNext = (corner >> axis) & 1;
      weight *= isNext ? share[axis]! : 1 - share[axis]!;
      index += (cell[axis]! + isNext) * strides[axis]!;
    }
    sum += weight * depths[index]!;
  }
  return sum;
}

/** Two ends, pixels of the picture. */
export type Segment = readonly [PagePoint, PagePoint];

const kept = new WeakMap<RegionGrid, Map<string, Segment[]>>();
const kMostKept = 12; // planes

/** The border in a plane; none where the plane does not pass through the region. Found once for each plane. */
export function borderIn(grid: RegionGrid, plane: ShownPlane): Segment[] {
  const found = kept.get(grid) ?? new Map<string, Segment[]>();
  kept.set(grid, found);
  const key = JSON.stringify(plane);
  const before = found.get(key);
  if (before) return before;
  if (found.size >= kMostKept) found.clear();
  const made = madeBorder(grid, plane);
  found.set(key, made);
  return made;
}

function madeBorder(grid: RegionGrid, plane: ShownPlane): Segment[] {
  const { right, up, centre, part, fieldMm } = plane;
  const half = grid.size.map((cells) => ((cells - 1) / 2) * grid.stepMm);
  const middle = grid.first.map((mm, axis) => mm + half[axis]!);
  const away: Mm = [middle[0]! - centre.x, middle[1]! - centre.y, middle[2]! - centre.z];
  const along = ({ x, y, z }: ShownPlane["right"], of: Mm) => x * of[0] + y * of[1] + z * of[2];
  const reach = ({ x, y, z }: ShownPlane["right"]) =>
    Math.abs(x) * half[0]! + Math.abs(y) * half[1]! + Math.abs(z) * half[2]!;
  const [x, y, z] = acrossOf(plane);
  const across = { x, y, z };
  if (Math.abs(along(across, away)) > reach(across)) return [];
  const from = { right: along(right, away) - reach(right), up: along(up, away) - reach(up) };
  const longest = 2 * Math.max(reach(right), reach(up));
  const step = Math.max(grid.stepMm / kStepsACell, longest / kMostSteps);
  const columns = Math.ceil((2 * reach(right)) / step) + 1;
  const rows = Math.ceil((2 * reach(up)) / step) + 1;
  const placeOf = (column: number, row: number) => ({ right: from.right + column * step, up: from.up + row * step });
  const depths = Array.from({ length: columns * rows }, (_, index) => {
    const place = placeOf(index % columns, Math.floor(index / columns));
    const mm = (axis: "x" | "y" | "z") => centre[axis] + place.right * right[axis] + place.up * up[axis];
    return depthAt(grid, [mm("x"), mm("y"), mm("z")]) - kBorder;
  });
  const pixel = (column: number, row: number): PagePoint => {
    const place = placeOf(column, row);
    return pixelOf({ rightMm: place.right, upMm: place.up }, part, fieldMm);
  };
  const isSeen = ({ x, y }: PagePoint) =>
    x >= part.left && y >= part.top && x < part.left + part.width && y < part.top + part.height;
  const segments: Segment[] = [];
  for (let row = 0; row + 1 < rows; ++row) {
    for (let column = 0; column + 1 < columns; ++column) {
      // Its corners, and the places on its sides where the border passes, in order.
      const corners = [
        [column, row],
        [column + 1, row],
        [column + 1, row + 1],
        [column, row + 1],
      ] as const;
      const crossings = corners.flatMap(([x, y], index) => {
        const [toX, toY] = corners[(index + 1) % 4]!;
        const [here, there] = [depths[y * columns + x]!, depths[toY * columns + toX]!];
        if (here >= 0 === there >= 0) return [];
        const share = here / (here - there);
        return [pixel(x + share * (toX - x), y + share * (toY - y))];
      });
      for (let index = 0; index + 1 < crossings.length; index += 2) {
        const segment = [crossings[index]!, crossings[index + 1]!] as const;
        if (segment.every(isSeen)) segments.push(segment);
      }
    }
  }
  return segments;
}
