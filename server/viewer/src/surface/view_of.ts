// SPDX-License-Identifier: Apache-2.0
// Views: where the pixels of a picture lie in the transducer frame, as picture_view() in renderer/parameters.
import { create } from "@bufbuild/protobuf";
import { ViewSchema, type Picture, type View } from "../../generated/fanlight_pb.js";
import { bodyWay, type Rectangle } from "../view_geometry";
import type { SceneValues } from "./light_parameters";

type Vector = [number, number, number];

/** The view of the camera of a scene, for the part of the picture that shows the surface. */
export function viewOf(scene: SceneValues, part: Rectangle): View {
  const number = (name: string) => scene.number(`camera.${name}`);
  const turn = { yawDeg: number("yaw_deg"), pitchDeg: number("pitch_deg"), rollDeg: number("roll_deg") };
  const way = (right: number, up: number, forward: number): Vector => {
    const { x, y, z } = bodyWay(turn, right, up, forward);
    return [x, y, z];
  };
  const [right, down, forward] = [way(1, 0, 0), way(0, -1, 0), way(0, 0, 1)];
  const target: Vector = [number("target_x_mm"), number("target_y_mm"), number("target_z_mm")];
  const distanceMm = number("distance_mm");
  // Beside the volume the field spans the smaller side (viewport() in renderer/parameters).
  const side = scene.choice("mode") === "surface-and-volume" ? Math.min(part.width, part.height) : part.height;
  const pixelMm = number("field_mm") / side;
  const eyeMm = number("field_mm") / (2 * Math.tan((number("opening_deg") * Math.PI) / 360));
  const widens = scene.choice("camera.projection") === "perspective";
  const rows = [0, 1, 2].flatMap((axis) => [
    right[axis]!,
    down[axis]!,
    forward[axis]!,
    target[axis]! - distanceMm * forward[axis]!,
  ]);
  return create(ViewSchema, {
    matrix: [...rows, 0, 0, 0, 1],
    mmPerPixel: pixelMm * (widens ? (eyeMm - distanceMm) / eyeMm : 1),
    mmPerPixelPerMm: widens ? pixelMm / eyeMm : 0,
    middleColumn: part.left + 0.5 * (part.width - 1),
    middleRow: part.top + 0.5 * (part.height - 1),
  });
}

export function sameView(a: View, b: View): boolean {
  const alike = (x: number, y: number) => Math.abs(x - y) < 1e-4;
  return (
    a.matrix.every((value, index) => alike(value, b.matrix[index] ?? NaN)) &&
    alike(a.mmPerPixel * 1000, b.mmPerPixel * 1000) &&
    alike(a.mmPerPixelPerMm * 1e5, b.mmPerPixelPerMm * 1e5)
  );
}

/** Whether one picture shows the view of another with more pixels. */
export function isFiner(one: Pick<Picture, "view" | "height">, other: Pick<Picture, "view" | "height">): boolean {
  return (one.view && other.view && one.height > other.height && sameViewInAnySize(one.view, other.view)) ?? false;
}

/** Whether two pictures show the same, with as many pixels or not. */
export function sameViewInAnySize(a: View, b: View): boolean {
  return sameView(coarserView(a, b.mmPerPixel / a.mmPerPixel), b) && Math.abs(heightOf(a) / heightOf(b) - 1) < 1e-6;
}

/** In the view plane, mm. */
function heightOf({ middleRow, mmPerPixel }: View): number {
  return (2 * middleRow + 1) * mmPerPixel;
}

/** Between the directions in which two views look, degrees. */
export function degreesBetween(a: View, b: View): number {
  const [from, to] = [columnOf(a, 2), columnOf(b, 2)];
  return (Math.acos(Math.min(1, Math.max(-1, dot(from, to)))) * 180) / Math.PI;
}

/** From right, down and depth in one view to the same in another, mm: 4 x 4, column by column. */
export function turnBetween(from: View, to: View): number[] {
  const axes = [0, 1, 2].map((axis) => columnOf(to, axis));
  const origin = columnOf(to, 3);
  const seen = (vector: Vector) => axes.map((axis) => dot(vector, axis));
  const fromOrigin = columnOf(from, 3);
  const apart: Vector = [fromOrigin[0] - origin[0], fromOrigin[1] - origin[1], fromOrigin[2] - origin[2]];
  return [...[0, 1, 2].flatMap((axis) => [...seen(columnOf(from, axis)), 0]), ...seen(apart), 1];
}

/** The view of a picture of which each pixel is the first of level x level ones. */
export function coarserView(view: View, level: number): View {
  return create(ViewSchema, {
    matrix: [...view.matrix],
    mmPerPixel: view.mmPerPixel * level,
    mmPerPixelPerMm: view.mmPerPixelPerMm * level,
    middleColumn: view.middleColumn / level,
    middleRow: view.middleRow / level,
  });
}

/** The point of the body at a depth of a pixel, mm. */
export function bodyPoint(view: View, column: number, row: number, depthMm: number): Vector {
  const scale = view.mmPerPixel + depthMm * view.mmPerPixelPerMm;
  const [right, down, forward, origin] = [0, 1, 2, 3].map((axis) => columnOf(view, axis)) as [
    Vector,
    Vector,
    Vector,
    Vector,
  ];
  const across = scale * (column - view.middleColumn);
  const below = scale * (row - view.middleRow);
  const at = (axis: 0 | 1 | 2) => origin[axis] + depthMm * forward[axis] + across * right[axis] + below * down[axis];
  return [at(0), at(1), at(2)];
}

function columnOf({ matrix }: View, column: number): Vector {
  return [matrix[column] ?? 0, matrix[4 + column] ?? 0, matrix[8 + column] ?? 0];
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
