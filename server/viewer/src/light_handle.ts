// The light's place over the picture, and the hand that moves it.
import type { SceneEditor } from "./scene_editor";
import { pictureFraction, tidy, viewPoint, type PagePoint } from "./view_geometry";

const kNudge = 0.02; // of the picture's height

export class LightHandle {
  constructor(
    private readonly editor: SceneEditor,
    private readonly canvas: HTMLCanvasElement,
    private readonly marker: SVGElement,
  ) {}

  /** The light goes to the pointer, at the depth it has. */
  moveTo(pointer: PagePoint): void {
    const point = viewPoint(pointer, this.canvas.getBoundingClientRect(), this.fieldMm());
    this.editor.set([
      ["light.right_mm", point.rightMm],
      ["light.up_mm", point.upMm],
    ]);
  }

  nudge(right: number, up: number): void {
    const step = kNudge * this.fieldMm();
    this.editor.set([
      ["light.right_mm", tidy(this.editor.get("light.right_mm") + right * step)],
      ["light.up_mm", tidy(this.editor.get("light.up_mm") + up * step)],
    ]);
  }

  /** Positive moves it into the body. */
  deepen(nudges: number): void {
    const depthMm = this.editor.get("light.depth_mm") + nudges * kNudge * this.fieldMm();
    this.editor.set([["light.depth_mm", tidy(depthMm)]]);
  }

  /** A light beside the picture is marked at its edge. */
  placeMarker(): void {
    const point = { rightMm: this.editor.get("light.right_mm"), upMm: this.editor.get("light.up_mm") };
    const { x, y } = pictureFraction(point, this.canvas.width / this.canvas.height, this.fieldMm());
    const inside = x >= 0 && x <= 1 && y >= 0 && y <= 1;
    this.marker.classList.toggle("beside", !inside);
    this.marker.style.setProperty("--x", String(Math.min(1, Math.max(0, x))));
    this.marker.style.setProperty("--y", String(Math.min(1, Math.max(0, y))));
  }

  private fieldMm(): number {
    return this.editor.get("camera.field_mm");
  }
}
