// SPDX-License-Identifier: Apache-2.0
// Lines, crosses and texts of a measurement over the picture.
import { drawing } from "../element";
import type { PagePoint } from "../view_geometry";
import type { ShownPlane } from "../shown_planes";
import { ellipseOf, ellipsePoints, figureText, type Mm } from "./figures";
import { drawnAt, placesIn } from "./measured_places";
import type { Measurement } from "./measurement_list";
import { borderIn, type RegionGrid } from "./region_border";

const kArm = 6; // of a cross
const kCharacter = 8.5; // about the width of one in a label

export interface DrawnMeasurement {
  measurement: Measurement;
  parts: SVGElement[];
}

/**
 * `place`: where a point of the body is drawn. `width`: of the picture. undefined where the picture does not show all of
 * its points.
 */
export function drawnParts(
  measurement: Measurement,
  place: (point: Mm) => PagePoint | undefined,
  width: number,
): SVGElement[] | undefined {
  const corners = all(measurement.points.map(place));
  if (!corners || corners.length === 0) return undefined;
  const lines = linesOf(measurement).flatMap(({ points, dashed }) => {
    const line = all(points.map(place));
    return line ? [drawing("path", { d: pathOf(line), ...(dashed && { class: "path" }) })] : [];
  });
  const text = `${measurement.name}: ${figureText(measurement.figures[0]!)}`;
  const { x, y } = labelPlace(measurement.kind, corners);
  const label = drawing("text", { x: Math.min(x, width - kCharacter * text.length), y }, text);
  return [...lines, ...corners.map(crossAt), label];
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
    const at = placesIn(plane, height)(points[0]!);
    if (!at) return [];
    const text = `${measurement.name}: ${figureText(measurement.figures[0]!)}`;
    return [crossAt(at), drawing("text", { x: at.x + 8, y: at.y - 8 }, text)];
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
  const { x, y } = kind === "distance" ? { x: (first.x + last.x) / 2, y: (first.y + last.y) / 2 } : last;
  return { x: x + 8, y: y - 8 };
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
