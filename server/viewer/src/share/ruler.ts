// SPDX-License-Identifier: Apache-2.0
// Measures straight distances on a shared surface, in the view that was cast.
import { drawing } from "../element";
import type { SurfaceView } from "../surface/surface_view";
import { picturePixel, type PagePoint } from "../view_geometry";

type Mm = readonly [number, number, number];

export class Ruler {
  private first: { pixel: PagePoint; point: Mm } | undefined;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly overlay: SVGSVGElement,
    private readonly view: SurfaceView,
    private readonly say: (sentence: string) => void,
  ) {}

  choose(chosen: boolean): void {
    this.forget();
    this.say(chosen ? "Click two points of the surface." : "");
  }

  forget(): void {
    this.first = undefined;
    this.overlay.replaceChildren();
  }

  clicked(pointer: PagePoint): void {
    if (this.view.isTurned) return this.say("A turned surface cannot be measured: reset the view.");
    const pixel = picturePixel(pointer, this.canvas);
    const point = this.view.pointAt(pixel);
    if (!point) return this.say("There is no surface at this point.");
    this.overlay.setAttribute("viewBox", `0 0 ${this.canvas.width} ${this.canvas.height}`);
    const arm = (6 * this.canvas.height) / 512; // pixels of a picture of the usual height
    const cross = drawing("path", {
      d: `M${pixel.x - arm} ${pixel.y}h${2 * arm}M${pixel.x} ${pixel.y - arm}v${2 * arm}`,
    });
    if (!this.first) {
      this.overlay.replaceChildren(cross);
      this.first = { pixel, point };
      return this.say("Now the second point.");
    }
    const { pixel: from, point: start } = this.first;
    const mm = Math.hypot(point[0] - start[0], point[1] - start[1], point[2] - start[2]);
    this.overlay.append(cross, drawing("path", { d: `M${from.x} ${from.y}L${pixel.x} ${pixel.y}` }));
    this.first = undefined;
    this.say(`${mm.toFixed(1)} mm straight. Not for diagnosis.`);
  }
}
