// SPDX-License-Identifier: Apache-2.0
// The colours of a depth map, with their depths in mm, beside the picture and as a sentence for stills.
import { element } from "./element";
import type { SettingsEditor } from "./settings_editor";
import { colourMapPoints } from "./surface/colour_maps";

const kTicks = 5;

/** The depths of the ticks, nearest first: rounded to what is legible. */
export function tickDepths(startMm: number, endMm: number): number[] {
  const step = (endMm - startMm) / (kTicks - 1);
  const digits = step < 2 ? 1 : 0;
  return Array.from({ length: kTicks }, (_, tick) => Number((startMm + tick * step).toFixed(digits)));
}

/** From near to far, as CSS colours at equal distances. */
export function legendColours(map: string): string[] {
  const points = colourMapPoints(map);
  const percents = (from: number) => points.slice(from, from + 3).map((part) => `${Math.round(100 * part)}%`);
  return [9, 6, 3, 0].map((from) => `rgb(${percents(from).join(" ")})`);
}

export class DepthLegend {
  constructor(
    private readonly root: HTMLElement,
    private readonly editor: Pick<SettingsEditor, "number" | "choice">,
  ) {}

  /** After a change of the scene. */
  refresh(): void {
    this.root.hidden = this.editor.choice("mode") !== "depth";
    if (this.root.hidden) return;
    this.root.style.setProperty("--colours", legendColours(this.editor.choice("finish.colours")).join(", "));
    const ticks = this.depths().map((mm) => element("span", { textContent: String(mm) }));
    this.root.replaceChildren(...ticks, element("span", { textContent: "mm" }));
  }

  /** "Depth: bright 20 mm, dark 160 mm."; empty in other modes. */
  text(): string {
    if (this.editor.choice("mode") !== "depth") return "";
    const depths = this.depths();
    return `Depth: bright ${depths[0]} mm, dark ${depths.at(-1)} mm.`;
  }

  private depths(): number[] {
    return tickDepths(this.editor.number("rays.start_mm"), this.editor.number("rays.end_mm"));
  }
}
