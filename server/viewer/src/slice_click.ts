// SPDX-License-Identifier: Apache-2.0
// A click on a plane: the clicked point becomes the target, through which the other planes go. In four panes the depths
// at which rays begin and end stay where they are in the body, so that the surface is not lost; it moves sideways with
// the target. A single oblique plane begins the search for the surface just before the point.
import type { SettingsEditor } from "./settings_editor";
import { planeAt, pointAt, shownPlanes, sliceCamera, type BodyPoint, type SliceCamera } from "./shown_planes";
import { bodyWay, picturePixel, tidy, type PagePoint, type Size } from "./view_geometry";

/** Where the rays begin before a clicked point: room for the detector's window and for a slanted surface. */
export const kBeforeClickMm = 10;

/** The point of the body that a slice shows at a pixel of the picture; undefined where no slice is. */
export function slicePoint(pixel: PagePoint, mode: string, size: Size, camera: SliceCamera): BodyPoint | undefined {
  const plane = planeAt(pixel, shownPlanes(mode, size, camera));
  if (!plane) return undefined;
  const { x, y, z } = pointAt(pixel, plane);
  return { x: tidy(x), y: tidy(y), z: tidy(z) };
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
    const camera = sliceCamera(this.editor);
    const { distanceMm } = camera;
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
