// SPDX-License-Identifier: Apache-2.0
// A click on a plane: the clicked point becomes the target, through which the other planes go. In four panes the depths
// at which rays begin and end stay where they are in the body, so that the surface is not lost; it moves sideways with
// the target. A single oblique plane begins the search for the surface just before the point.
import type { SettingsEditor } from "./settings_editor";
import { kAcross, kTomography, offsetMm, planeWay } from "./tomography";
import {
  bodyWay,
  picturePixel,
  scaleAt,
  tidy,
  viewPoint,
  type Lens,
  type PagePoint,
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
  /** Mode tomography: index of the direction of the planes, and their distance. */
  plane: number;
  stepMm: number;
}

/** Where the rays begin before a clicked point: room for the detector's window and for a slanted surface. */
export const kBeforeClickMm = 10;

/** The point of the body that a slice shows at a pixel of the picture; undefined where no slice is. */
export function slicePoint(pixel: PagePoint, mode: string, size: Size, camera: SliceCamera): BodyPoint | undefined {
  if (mode === "slice") return isBehindEye(camera) ? undefined : obliquePoint(pixel, size, camera);
  if (mode === kTomography) return tomographyPoint(pixel, size, camera);
  if (mode !== "slices") return undefined;
  // The panes as set_slices() in renderer/parameters/cast_parameters.cpp lays them out.
  const left = Math.floor(size.width / 2);
  const top = Math.floor(size.height / 2);
  const isRight = pixel.x >= left;
  const isLow = pixel.y >= top;
  if (isRight && isLow) return undefined; // the surface
  const pane = {
    left: isRight ? left : 0,
    top: isLow ? top : 0,
    width: isRight ? size.width - left : left,
    height: isLow ? size.height - top : top,
  };
  const { rightMm, upMm } = viewPoint(pixel, pane, camera.fieldMm);
  const { x, y, z } = camera.target;
  if (isRight) return { x, y: tidy(y - upMm), z: tidy(z + rightMm) };
  if (isLow) return { x: tidy(x + rightMm), y, z: tidy(z + upMm) };
  return { x: tidy(x + rightMm), y: tidy(y - upMm), z };
}

/** A point of one of nine planes, as set_tomography() in renderer/parameters/cast_parameters.cpp lays them out. */
function tomographyPoint(pixel: PagePoint, size: Size, camera: SliceCamera): BodyPoint {
  const edge = (length: number, number: number) => Math.floor((number * length) / kAcross);
  const within = (length: number, at: number) => [2, 1].find((number) => at >= edge(length, number)) ?? 0;
  const [column, row] = [within(size.width, pixel.x), within(size.height, pixel.y)];
  const [left, top] = [edge(size.width, column), edge(size.height, row)];
  const pane = { left, top, width: edge(size.width, column + 1) - left, height: edge(size.height, row + 1) - top };
  const { rightMm, upMm } = viewPoint(pixel, pane, camera.fieldMm);
  const awayMm = offsetMm(kAcross * row + column, camera.stepMm);
  const way = planeWay(camera.plane, camera, rightMm, upMm, awayMm);
  const { x, y, z } = camera.target;
  return { x: tidy(x + way.x), y: tidy(y + way.y), z: tidy(z + way.z) };
}

/** Such a plane is not shown. */
function isBehindEye({ perspective, fieldMm, openingDeg, distanceMm, sliceDepthMm }: SliceCamera): boolean {
  const eyeToTargetMm = fieldMm / (2 * Math.tan((openingDeg * Math.PI) / 360));
  return perspective && sliceDepthMm + eyeToTargetMm - distanceMm <= 0;
}

/** A point of the plane at right angles to the view. */
function obliquePoint(pixel: PagePoint, size: Size, camera: SliceCamera): BodyPoint {
  const whole = { left: 0, top: 0, ...size };
  const { rightMm, upMm } = viewPoint(pixel, whole, camera.fieldMm * scaleAt(camera.sliceDepthMm, camera));
  const way = bodyWay(camera, rightMm, upMm, camera.sliceDepthMm - camera.distanceMm);
  const { x, y, z } = camera.target;
  return { x: tidy(x + way.x), y: tidy(y + way.y), z: tidy(z + way.z) };
}

function along(point: BodyPoint, way: BodyPoint): number {
  return point.x * way.x + point.y * way.y + point.z * way.z;
}

export class SliceClick {
  /** `movesRays`: whether the rays may be changed; a view of one's own has those of the main view. */
  constructor(
    private readonly editor: Pick<SettingsEditor, "number" | "choice" | "set">,
    private readonly canvas: HTMLCanvasElement,
    private readonly movesRays: () => boolean,
  ) {}

  /** A click at a point of the page. */
  readonly clicked = (pointer: PagePoint): void => {
    const number = (name: string) => this.editor.number(name);
    const mode = this.editor.choice("mode");
    const distanceMm = number("camera.distance_mm");
    const camera: SliceCamera = {
      fieldMm: number("camera.field_mm"),
      distanceMm,
      perspective: this.editor.choice("camera.projection") === "perspective",
      openingDeg: number("camera.opening_deg"),
      target: { x: number("camera.target_x_mm"), y: number("camera.target_y_mm"), z: number("camera.target_z_mm") },
      yawDeg: number("camera.yaw_deg"),
      pitchDeg: number("camera.pitch_deg"),
      rollDeg: number("camera.roll_deg"),
      sliceDepthMm: number("slice.depth_mm"),
      plane: number("slice.plane"),
      stepMm: number("slice.step_mm"),
    };
    const point = slicePoint(picturePixel(pointer, this.canvas), mode, this.canvas, camera);
    if (!point) return;
    if (mode === "slice" && !this.movesRays()) return; // the plane would move along with the target, off the point
    const values: [string, number][] = [
      ["camera.target_x_mm", point.x],
      ["camera.target_y_mm", point.y],
      ["camera.target_z_mm", point.z],
    ];
    if (mode === "slice") {
      // The view plane keeps its distance from the target.
      values.push(["rays.start_mm", Math.max(0, tidy(distanceMm - kBeforeClickMm))]);
      values.push(["rays.end_mm", Math.max(number("rays.end_mm"), tidy(distanceMm + kBeforeClickMm))]);
      values.push(["slice.depth_mm", distanceMm]); // the same plane, through the target
    } else {
      // The view plane stays where it is: the depths at which rays begin and end are those of before.
      const forward = bodyWay(camera, 0, 0, 1);
      const deeper = along(point, forward) - along(camera.target, forward);
      values.push(["camera.distance_mm", Math.max(0, tidy(distanceMm + deeper))]);
    }
    this.editor.set(values);
  };
}
