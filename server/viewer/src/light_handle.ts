// The light's place over the picture, and the hand that moves it.
import type { SettingsEditor } from "./settings_editor";
import { pixelOf, scaleAt, surfacePart, tidy, viewPoint, type PagePoint, type Rectangle } from "./view_geometry";

const kNudge = 0.02; // of the height of what is seen

/** Where nothing is lit there is no marker, and no hand moves the light. */
export class LightHandle {
  constructor(
    private readonly editor: SettingsEditor,
    private readonly canvas: HTMLCanvasElement,
    private readonly marker: SVGElement,
    private readonly isLit: () => boolean,
  ) {}

  /** The light goes to the pointer, at the depth it has. */
  moveTo(pointer: PagePoint): void {
    const part = this.part();
    if (!part) return;
    const shown = this.canvas.getBoundingClientRect();
    const pixel = {
      x: ((pointer.x - shown.left) * this.canvas.width) / shown.width,
      y: ((pointer.y - shown.top) * this.canvas.height) / shown.height,
    };
    const point = viewPoint(pixel, part, this.heightMm());
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

  /** Positive moves it into the body. */
  deepen(nudges: number): void {
    if (!this.part()) return;
    const depthMm = this.editor.number("light.depth_mm") + nudges * kNudge * this.editor.number("camera.field_mm");
    this.editor.set([["light.depth_mm", tidy(depthMm)]]);
  }

  /** A light beside the part of the picture that it lights is marked at the edge of that. */
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

  /** What the part covers at the light's depth. */
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
