// SPDX-License-Identifier: Apache-2.0
// Where the planes of a picture lie in the body: from a pixel to a point, and back.
import { kAcross, kTomography, offsetMm, paneTitle, planeWay } from "./tomography";
import { isTurned, planeTurn } from "./plane_turn";
import {
  bodyWay,
  pixelOf,
  scaleAt,
  viewPoint,
  type Lens,
  type PagePoint,
  type Rectangle,
  type Size,
  type Turn,
} from "./view_geometry";

/** In the transducer frame, mm. */
export interface BodyPoint {
  x: number;
  y: number;
  z: number;
}

export interface SliceCamera extends Lens, Turn {
  target: BodyPoint;
  sliceDepthMm: number;
  /** Turn of the planes A, B and C. */
  planes: Turn;
  /** Mode tomography: index of the direction of the planes, and their distance. */
  plane: number;
  stepMm: number;
}

export interface ShownPlane {
  name: string;
  /** The part of the picture that shows it. */
  part: Rectangle;
  /** The height of the part. */
  fieldMm: number;
  /** The point in the middle of the part, and directions of length 1. */
  centre: BodyPoint;
  right: BodyPoint;
  up: BodyPoint;
}

/** The values of the scene that place its planes. */
export function sliceCamera(editor: { number(name: string): number; choice(name: string): string }): SliceCamera {
  const number = (name: string) => editor.number(name);
  return {
    fieldMm: number("camera.field_mm"),
    distanceMm: number("camera.distance_mm"),
    perspective: editor.choice("camera.projection") === "perspective",
    openingDeg: number("camera.opening_deg"),
    target: { x: number("camera.target_x_mm"), y: number("camera.target_y_mm"), z: number("camera.target_z_mm") },
    yawDeg: number("camera.yaw_deg"),
    pitchDeg: number("camera.pitch_deg"),
    rollDeg: number("camera.roll_deg"),
    sliceDepthMm: number("slice.depth_mm"),
    planes: planeTurn(editor),
    plane: number("slice.plane"),
    stepMm: number("slice.step_mm"),
  };
}

/** The planes that a mode shows, laid out as renderer/parameters/cast_parameters.cpp does. */
export function shownPlanes(mode: string, size: Size, camera: SliceCamera): ShownPlane[] {
  if (mode === "slice") return isBehindEye(camera) ? [] : [obliquePlane(size, camera)];
  if (mode === kTomography) return tomographyPlanes(size, camera);
  return mode === "slices" ? panes(size, camera) : [];
}

export function planeAt({ x, y }: PagePoint, planes: readonly ShownPlane[]): ShownPlane | undefined {
  return planes.find(
    ({ part }) => x >= part.left && y >= part.top && x < part.left + part.width && y < part.top + part.height,
  );
}

export function pointAt(pixel: PagePoint, { part, fieldMm, centre, right, up }: ShownPlane): BodyPoint {
  const { rightMm, upMm } = viewPoint(pixel, part, fieldMm);
  return added(centre, right, rightMm, up, upMm);
}

/** The pixel of a point, and how far before or behind the plane it lies. */
export function pixelIn(point: BodyPoint, plane: ShownPlane): { pixel: PagePoint; asideMm: number } {
  const away = { x: point.x - plane.centre.x, y: point.y - plane.centre.y, z: point.z - plane.centre.z };
  const along = (way: BodyPoint) => away.x * way.x + away.y * way.y + away.z * way.z;
  const [rightMm, upMm] = [along(plane.right), along(plane.up)];
  const inPlane = added({ x: 0, y: 0, z: 0 }, plane.right, rightMm, plane.up, upMm);
  const asideMm = Math.hypot(away.x - inPlane.x, away.y - inPlane.y, away.z - inPlane.z);
  return { pixel: pixelOf({ rightMm, upMm }, plane.part, plane.fieldMm), asideMm };
}

function added(from: BodyPoint, right: BodyPoint, rightMm: number, up: BodyPoint, upMm: number): BodyPoint {
  const sum = (axis: keyof BodyPoint) => from[axis] + rightMm * right[axis] + upMm * up[axis];
  return { x: sum("x"), y: sum("y"), z: sum("z") };
}

function panes({ width, height }: Size, camera: SliceCamera): ShownPlane[] {
  const { target, fieldMm, planes } = camera;
  const [left, top] = [Math.floor(width / 2), Math.floor(height / 2)];
  const upper = { top: 0, height: top };
  const turned = isTurned(planes) ? " (turned)" : "";
  const of = (name: string, plane: number, part: Rectangle): ShownPlane => {
    const way = (right: number, up: number) => planeWay(plane, { view: camera, planes }, right, up, 0);
    return { name: `plane ${name}${turned}`, part, fieldMm, centre: target, right: way(1, 0), up: way(0, 1) };
  };
  return [
    of("A", 0, { left: 0, width: left, ...upper }),
    of("B", 1, { left, width: width - left, ...upper }),
    of("C", 2, { left: 0, width: left, top, height: height - top }),
  ];
}

function tomographyPlanes(size: Size, camera: SliceCamera): ShownPlane[] {
  const edge = (length: number, number: number) => Math.floor((number * length) / kAcross);
  return Array.from({ length: kAcross ** 2 }, (_, pane) => {
    const [column, row] = [pane % kAcross, Math.floor(pane / kAcross)];
    const [left, top] = [edge(size.width, column), edge(size.height, row)];
    const turns = { view: camera, planes: camera.planes };
    const way = (right: number, up: number, away: number) => planeWay(camera.plane, turns, right, up, away);
    const offset = way(0, 0, offsetMm(pane, camera.stepMm));
    return {
      name: nameOf(paneTitle(camera.plane, pane, camera.stepMm, camera.planes)),
      part: { left, top, width: edge(size.width, column + 1) - left, height: edge(size.height, row + 1) - top },
      fieldMm: camera.fieldMm,
      centre: added(camera.target, offset, 1, offset, 0),
      right: way(1, 0, 0),
      up: way(0, 1, 0),
    };
  });
}

/** "plane A −5 mm", "the plane as seen +5 mm" */
function nameOf(title: string): string {
  return title.startsWith("As seen") ? `the plane as seen${title.slice("As seen".length)}` : `plane ${title}`;
}

/** Such a plane is not shown. */
function isBehindEye({ perspective, fieldMm, openingDeg, distanceMm, sliceDepthMm }: SliceCamera): boolean {
  const eyeToTargetMm = fieldMm / (2 * Math.tan((openingDeg * Math.PI) / 360));
  return perspective && sliceDepthMm + eyeToTargetMm - distanceMm <= 0;
}

/** The plane at right angles to the view. */
function obliquePlane({ width, height }: Size, camera: SliceCamera): ShownPlane {
  const forward = bodyWay(camera, 0, 0, 1);
  return {
    name: "the plane as seen",
    part: { left: 0, top: 0, width, height }, // a canvas cannot be spread
    fieldMm: camera.fieldMm * scaleAt(camera.sliceDepthMm, camera),
    centre: added(camera.target, forward, camera.sliceDepthMm - camera.distanceMm, forward, 0),
    right: bodyWay(camera, 1, 0, 0),
    up: bodyWay(camera, 0, 1, 0),
  };
}
