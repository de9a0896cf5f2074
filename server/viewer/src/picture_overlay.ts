// SPDX-License-Identifier: Apache-2.0
// Everything that the page draws over the picture but the light, and the still that is saved with it.
import type { Hello, Picture } from "../generated/fanlight_pb.js";
import { find } from "./element";
import { Measurement } from "./measurement";
import { page } from "./page";
import { PictureMarks, scaleBar, type ScaleBar } from "./picture_marks";
import type { SettingsEditor } from "./settings_editor";
import { saveStill } from "./still";
import type { PagePoint } from "./view_geometry";

const kSurfaceModes = ["surface", "surface-and-volume", "depth", "slices"];

export class PictureOverlay {
  readonly measurement: Measurement;
  private readonly lines = find("#measurement", SVGSVGElement);
  private readonly marks = new PictureMarks(
    {
      scale: find("#scale", HTMLElement),
      axes: find("#axes", SVGSVGElement),
      paneNames: find("#pane-names", HTMLElement),
    },
    page.frame,
  );

  constructor(
    private readonly editor: Pick<SettingsEditor, "number" | "choice">,
    private readonly from: {
      hello(): Hello | undefined;
      shown(): Picture | undefined;
      isFrozen(): boolean;
      mayFreeze(): boolean;
      askDepth(requestId: bigint, pixels: PagePoint[]): void;
      failed(sentence: string): void;
    },
  ) {
    this.measurement = new Measurement(page.canvas, this.lines, {
      isFrozen: () => from.isFrozen(),
      mayFreeze: () => from.mayFreeze(),
      showsSurface: () => kSurfaceModes.includes(this.editor.choice("mode")),
      fullSize: () => this.fullSize(),
      ask: (requestId, pixels) => from.askDepth(requestId, pixels),
      say: (sentence) => {
        page.measured.textContent = sentence;
        page.measured.hidden = sentence === "";
      },
    });
    new ResizeObserver(() => this.showMarks()).observe(page.frame);
  }

  show(picture: Picture): void {
    this.measurement.show(picture);
    this.showMarks();
  }

  /** Saves the picture with its scale. */
  still(): void {
    if (page.frame.hidden) return this.from.failed("There is no picture to save yet.");
    const facts = {
      source: this.from.hello()?.title ?? "",
      state: find("#connection", HTMLElement).innerText.trim(),
      measurement: this.measurement.text(),
      bar: this.bar(),
      fullWidth: this.fullSize().width,
    };
    saveStill(page.canvas, this.lines, facts).catch((error: Error) => this.from.failed(error.message));
  }

  private fullSize(): { width: number; height: number } {
    const hello = this.from.hello();
    return { width: hello?.pictureWidth ?? 0, height: hello?.pictureHeight ?? 0 };
  }

  private bar(): ScaleBar | undefined {
    return scaleBar(this.from.shown()?.view, this.fullSize().width, this.editor.number("camera.distance_mm"));
  }

  private showMarks(): void {
    page.frame.dataset.mode = this.editor.choice("mode");
    this.marks.show(this.from.shown()?.view, this.bar(), this.fullSize().width, this.editor.choice("mode"));
  }
}
