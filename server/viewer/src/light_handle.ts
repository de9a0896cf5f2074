// SPDX-License-Identifier: Apache-2.0
// The marker of the light over the picture, and its movement by the pointer.
import type { SettingsEditor } from "./settings_editor";
import {
  picturePixel,
  pixelOf,
  scaleAt,
  surfacePart,
  tidy,
  viewPoint,
  type PagePoint,
  type Rectangle,
} from "./view_geometry";

const kNudge = 0.02; // share of the visible height, per nudge

/** In modes that light nothing there is no marker, and the light cannot be moved. */
export class LightHandle {
  constructor(
    private readonly editor: SettingsEditor,
    private readonly canvas: HTMLCanvasElement,
    private readonly marker: SVGElement,
    private readonly isLit: () => boolean,
  ) {}

  /** Moves the light to the pointer; its depth stays. */
  moveTo(pointer: PagePoint): void {
    const part = this.part();
    if (!part) return;
    const point = viewPoint(picturePixel(pointer, this.canvas), part, this.heightMm());
    this.editor.set([
      ["light.right_mm", point.rightMm],
      ["light.up_mm", point.upMm],
    ]);
  }

  nudge(right: number, up: number): void {
    if (!this.part()) return;
    const step = kNudge * this.heightMm();
    this.editor.set([
      ["light.right_mm", tidy(this.editor.number("light.right_mm") + right * step)],
      ["light.up_mm", tidy(this.editor.number("light.up_mm") + up * step)],
    ]);
  }

  /** Positive numbers move the light into the body. */
  deepen(nudges: number): void {
    if (!this.part()) return;
    const depthMm = this.editor.number("light.depth_mm") + nudges * kNudge * this.editor.number("camera.field_mm");
    this.editor.set([["light.depth_mm", tidy(depthMm)]]);
  }

  /** Draws the marker. A light outside the lit part of the picture is drawn at the edge of that part. */
  placeMarker(): void {
    const part = this.part();
    this.marker.classList.toggle("absent", !part);
    if (!part) return;
    const point = { rightMm: this.editor.number("light.right_mm"), upMm: this.editor.number("light.up_mm") };
    const { x, y } = pixelOf(point, part, this.heightMm());
    const [right, bottom] = [part.left + part.width, part.top + part.height];
    this.marker.classList.toggle("beside", x < part.left || x > right || y < part.top || y > bottom);
    this.setFractions({ "--x": x, "--left": part.left, "--right": right }, this.canvas.width);
    this.setFractions({ "--y": y, "--top": part.top, "--bottom": bottom }, this.canvas.height);
  }

  private setFractions(pixels: Record<string, number>, whole: number): void {
    for (const [name, pixel] of Object.entries(pixels)) this.marker.style.setProperty(name, String(pixel / whole));
  }

  private part(): Rectangle | undefined {
    return this.isLit() ? surfacePart(this.editor.choice("mode"), this.canvas) : undefined;
  }

  /** Height in mm that the lit part covers at the depth of the light. */
  private heightMm(): number {
    const lens = {
      fieldMm: this.editor.number("camera.field_mm"),
      distanceMm: this.editor.number("camera.distance_mm"),
      perspective: this.editor.choice("camera.projection") === "perspective",
      openingDeg: this.editor.number("camera.opening_deg"),
    };
    return lens.fieldMm * scaleAt(this.editor.number("light.depth_mm"), lens);
  }
}
