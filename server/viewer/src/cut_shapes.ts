// SPDX-License-Identifier: Apache-2.0
// The shapes of the scalpel as the setting cuts.shapes has them (proto/model/cut_list.hpp), from what is drawn over the
// picture.
import type { View } from "../generated/fanlight_pb.js";
import type { Mm } from "./measuring/figures";
import type { PagePoint } from "./view_geometry";

/** What the server takes. */
export const kMostCuts = 24;
const kMostNumbers = 1536;
const kMostCorners = 96; // of a lasso
const kEveryDepthMm = 3000;

export type LassoKind = "inside" | "outside";

/** The cuts in the text of the setting, one text each. */
export function cutsOf(text: string): string[] {
  return text
    .split(";")
    .map((cut) => cut.trim())
    .filter(Boolean);
}

/** "Cut away: 3 parts"; empty: nothing is. */
export function cutsText(shapes: string): string {
  const { length } = cutsOf(shapes);
  return length === 0 ? "" : `Cut away: ${length} ${length === 1 ? "part" : "parts"}`;
}

/** The setting with one more cut; undefined where there is no room for it. */
export function withCut(text: string, cut: string): string | undefined {
  const cuts = [...cutsOf(text), cut];
  const numbers = cuts.reduce((sum, each) => sum + numbersOf(each), 0);
  return cuts.length > kMostCuts || numbers > kMostNumbers ? undefined : cuts.join("; ");
}

/** How many coordinates a cut has. */
function numbersOf(cut: string): number {
  return cut
    .replace(/^.*\b(outline|at)\b/, "")
    .trim()
    .split(/\s+/).length;
}

/** Whether two texts have the same cuts: the server writes numbers its own way. */
export function sameCuts(a: string, b: string): boolean {
  const [words, others] = [a, b].map((text) => cutsOf(text).join(" ; ").split(/\s+/)) as [string[], string[]];
  const isSame = (word: string, other: string) => word === other || Math.abs(Number(word) - Number(other)) < 1e-3;
  return words.length === others.length && words.every((word, index) => isSame(word, others[index]!));
}

/** Millimetres that a pixel of the view covers at a depth below its plane. */
export function pixelMmAt(view: View, depthMm: number): number {
  return view.mmPerPixel + depthMm * view.mmPerPixelPerMm;
}

/**
 * A lasso, drawn in the plane at `planeMm` below the view plane, which lies before the eye. `pixels`: of the picture that
 * the view is of. `farthestMm`: how deep below the view plane it cuts; without, through everything.
 */
export function lassoCut(
  kind: LassoKind,
  pixels: readonly PagePoint[],
  view: View,
  planeMm: number,
  farthestMm?: number,
): string {
  const m = view.matrix;
  const column = (at: number, sign = 1) => [m[at]!, m[4 + at]!, m[8 + at]!].map((value) => rounded(sign * value, 6));
  const pixelMm = pixelMmAt(view, planeMm);
  const eyeMm = view.mmPerPixelPerMm > 0 ? pixelMm / view.mmPerPixelPerMm : 0;
  const origin = [3, 7, 11].map((at, axis) => rounded(m[at]! + planeMm * m[4 * axis + 2]!));
  const corners = simplified(pixels).flatMap(({ x, y }) => [
    rounded((x - view.middleColumn) * pixelMm),
    rounded((view.middleRow - y) * pixelMm),
  ]);
  return [
    [kind, -kEveryDepthMm, farthestMm === undefined ? kEveryDepthMm : rounded(farthestMm - planeMm)],
    ["from", ...origin],
    ["right", ...column(0)],
    ["up", ...column(1, -1)],
    ["eye", rounded(eyeMm)],
    ["outline", ...corners],
  ]
    .flat()
    .join(" ");
}

export function ballsCut(radiusMm: number, centres: readonly Mm[]): string {
  return ["balls", radiusMm, "at", ...centres.flat().map((value) => rounded(value))].join(" ");
}

/** The depth of a point below the view plane, mm. */
export function depthOf([x, y, z]: Mm, { matrix: m }: View): number {
  return (x - m[3]!) * m[2]! + (y - m[7]!) * m[6]! + (z - m[11]!) * m[10]!;
}

/** The point at a depth below the view plane that is seen at a pixel. */
export function pointAt({ x, y }: PagePoint, depthMm: number, view: View): Mm {
  const m = view.matrix;
  const pixelMm = pixelMmAt(view, depthMm);
  const [right, down] = [(x - view.middleColumn) * pixelMm, (y - view.middleRow) * pixelMm];
  const part = (row: number) => m[row + 3]! + depthMm * m[row + 2]! + right * m[row]! + down * m[row + 1]!;
  return [part(0), part(4), part(8)];
}

/** By the even-odd rule. */
export function isInside(outline: readonly PagePoint[], { x, y }: PagePoint): boolean {
  return outline.reduce((inside, a, index) => {
    const b = outline[(index + 1) % outline.length]!;
    const crosses = a.y > y !== b.y > y && x < a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x);
    return crosses ? !inside : inside;
  }, false);
}

/** About `most` places inside an outline, on a grid. */
export function placesInside(outline: readonly PagePoint[], most = 400): PagePoint[] {
  const [left, right] = [Math.min(...outline.map(({ x }) => x)), Math.max(...outline.map(({ x }) => x))];
  const [top, bottom] = [Math.min(...outline.map(({ y }) => y)), Math.max(...outline.map(({ y }) => y))];
  const apart = Math.max(1, Math.sqrt(((right - left) * (bottom - top)) / most));
  const places: PagePoint[] = [];
  for (let y = top + apart / 2; y < bottom; y += apart)
    for (let x = left + apart / 2; x < right; x += apart) if (isInside(outline, { x, y })) places.push({ x, y });
  return places;
}

/** The outline with at most kMostCorners: those are left out that lie near the line between their neighbours. */
export function simplified(outline: readonly PagePoint[]): PagePoint[] {
  let corners = [...outline];
  for (let pixels = 0.5; ; pixels *= 1.5) {
    corners = withoutNear(outline, pixels);
    if (corners.length <= kMostCorners) return corners;
  }
}

/** Ramer, Douglas and Peucker's, on the outline as an open line. */
function withoutNear(line: readonly PagePoint[], pixels: number): PagePoint[] {
  const [first, last] = [line[0]!, line.at(-1)!];
  if (line.length < 3) return [...line];
  let farthest = 0;
  let at = 0;
  line.forEach((point, index) => {
    const distance = distanceTo(point, first, last);
    if (distance > farthest) [farthest, at] = [distance, index];
  });
  if (farthest <= pixels) return [first, last];
  return [...withoutNear(line.slice(0, at + 1), pixels).slice(0, -1), ...withoutNear(line.slice(at), pixels)];
}

function distanceTo(point: PagePoint, a: PagePoint, b: PagePoint): number {
  const [x, y] = [b.x - a.x, b.y - a.y];
  const length = Math.hypot(x, y);
  if (length < 1e-9) return Math.hypot(point.x - a.x, point.y - a.y);
  return Math.abs(x * (point.y - a.y) - y * (point.x - a.x)) / length;
}

function rounded(value: number, digits = 2): number {
  return Number(value.toFixed(digits)) + 0; // no -0
}
