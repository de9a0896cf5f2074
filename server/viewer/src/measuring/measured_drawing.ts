// SPDX-License-Identifier: Apache-2.0
// Lines, crosses and texts of a measurement over the picture.
import { drawing } from "../element";
import type { PagePoint } from "../view_geometry";
import type { ShownPlane } from "../shown_planes";
import { ellipseOf, ellipsePoints, figureText, type Mm } from "./figures";
import { drawnAt, paneOf, type Pane } from "./measured_places";
import type { Measurement } from "./measurement_list";
import { borderIn, type RegionGrid } from "./region_border";

const kArm = 6; // of a cross
const kCharacter = 11; // at most the mean width of one in a label, in any font

export interface DrawnMeasurement {
  measurement: Measurement;
  parts: SVGElement[];
}

/** undefined where the pane does not show all of its points. */
export function drawnParts(measurement: Measurement, { place, right, isBehind }: Pane): SVGElement[] | undefined {
  const corners = all(measurement.points.map(place));
  if (!corners || corners.length === 0) return undefined;
  const lines = linesOf(measurement).flatMap(({ points, dashed }) => {
    const line = all(points.map(place));
    return line ? [drawing("path", { d: pathOf(line), ...(dashed && { class: "path" }) })] : [];
  });
  const label = labelAt(measurement, labelPlace(measurement.kind, corners), right);
  const parts = [...lines, ...corners.map(crossAt), label];
  if (isBehind && measurement.points.some(isBehind)) parts.forEach(({ classList }) => classList.add("behind"));
  return parts;
}

/** The border of a region in each plane that passes through it. `height`: of the picture, pixels. */
export function borderParts(
  grid: RegionGrid,
  planes: readonly ShownPlane[],
  height: number,
  kind: "kept" | "offered" = "kept",
): SVGElement[] {
  return planes.flatMap((plane) => {
    const lines = borderIn(grid, plane).map((ends) => pathOf(ends.map((end) => drawnAt(end, height))));
    return lines.length > 0 ? [drawing("path", { d: lines.join(""), class: `region ${kind}` })] : [];
  });
}

/** The same of a measurement, with its label beside the point from which it was grown, where a plane shows it. */
export function fluidParts(
  measurement: Measurement,
  planes: readonly ShownPlane[],
  height: number,
): SVGElement[] | undefined {
  const { region, points } = measurement;
  const border = region ? borderParts(region, planes, height) : [];
  if (border.length === 0) return undefined;
  const labels = planes.flatMap((plane) => {
    const { place, right } = paneOf(plane, height);
    const at = place(points[0]!);
    return at ? [crossAt(at), labelAt(measurement, at, right)] : [];
  });
  return [...border, ...labels.slice(0, 2)];
}

/** What is clicked so far. */
export function clickedParts(clicks: readonly PagePoint[], isOutline: boolean): SVGElement[] {
  const line = isOutline && clicks.length > 1 ? [drawing("path", { d: pathOf(clicks), class: "path" })] : [];
  return [...line, ...clicks.map(crossAt)];
}

/** Of the body; dashed: along the surface. */
function linesOf({ kind, points, path }: Measurement): { points: readonly Mm[]; dashed: boolean }[] {
  if (kind === "area") return [{ points: [...points, points[0]!], dashed: false }];
  if (kind !== "ellipse") return [{ points, dashed: false }, ...(path ? [{ points: path, dashed: true }] : [])];
  const ellipse = ellipseOf(points);
  return ellipse ? [{ points: ellipsePoints(ellipse), dashed: false }] : [];
}

/** Beside the middle of a distance, else beside the last point. */
function labelPlace(kind: Measurement["kind"], corners: readonly PagePoint[]): PagePoint {
  const [first, last] = [corners[0]!, corners.at(-1)!];
  return kind === "distance" ? { x: (first.x + last.x) / 2, y: (first.y + last.y) / 2 } : last;
}

/** Name and value beside a place, within its pane, which ends at `right`. */
function labelAt({ name, figures }: Measurement, { x, y }: PagePoint, right: number): SVGElement {
  const text = `${name}: ${figureText(figures[0]!)}`;
  const fits = x + 8 + kCharacter * text.length < right;
  const across = fits ? { x: x + 8 } : { x: right - 4, "text-anchor": "end" };
  return drawing("text", { ...across, y: y - 8 }, text);
}

function crossAt({ x, y }: PagePoint): SVGElement {
  return drawing("path", { d: `M${x - kArm} ${y}h${2 * kArm}M${x} ${y - kArm}v${2 * kArm}` });
}

function pathOf(line: readonly PagePoint[]): string {
  return `M${line.map(({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}`;
}

function all<T>(values: readonly (T | undefined)[]): T[] | undefined {
  return values.every((value) => value !== undefined) ? (values as T[]) : undefined;
}
