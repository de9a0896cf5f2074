// SPDX-License-Identifier: Apache-2.0
// What is drawn over the picture: a bar of a round length in mm, the directions of the probe.
import type { View } from "../generated/fanlight_pb.js";
import { drawing } from "./element";

const kLongestShare = 0.25; // of the picture's width
const kRoundMm = [0.5, 1, 2, 5, 10, 20, 50, 100, 200];
const kArm = 26;

export interface ScaleBar {
  mm: number;
  /** Of the picture in its full size. */
  pixels: number;
}

/** The longest round length that fits; at the depth of the target, where a perspective has its stated scale. */
export function scaleBar(view: View | undefined, width: number, targetMm: number): ScaleBar | undefined {
  if (!view) return undefined;
  const mmPerPixel = view.mmPerPixel + targetMm * view.mmPerPixelPerMm;
  if (!(mmPerPixel > 0)) return undefined;
  const mm = kRoundMm.filter((length) => length / mmPerPixel <= kLongestShare * width).at(-1);
  return mm === undefined ? undefined : { mm, pixels: mm / mmPerPixel };
}

/** Where a direction of the probe points in the picture: right and down, -1 to 1; "away" is into the picture. */
export interface Direction {
  name: string;
  right: number;
  down: number;
  away: number;
}

export function directions(view: View): Direction[] {
  const m = view.matrix;
  // The columns of the matrix are right, down and forward in the transducer frame.
  const axis = (name: string, row: number) => ({ name, right: m[row]!, down: m[row + 1]!, away: m[row + 2]! });
  return [axis("side", 0), axis("depth", 4), axis("sweep", 8)];
}

export class PictureMarks {
  constructor(
    private readonly places: { scale: HTMLElement; axes: SVGSVGElement },
    private readonly frame: HTMLElement,
  ) {}

  show(probe: readonly Direction[], bar: ScaleBar | undefined, fullWidth: number): void {
    const { scale, axes } = this.places;
    scale.hidden = !bar;
    if (bar) {
      scale.firstElementChild!.textContent = `${bar.mm} mm`;
      scale.style.setProperty("--length", String((bar.pixels * this.frame.clientWidth) / fullWidth));
    }
    axes.replaceChildren(...probe.flatMap(arm));
  }
}

function arm({ name, right, down, away }: Direction): SVGElement[] {
  const [x, y] = [kArm * right, kArm * down];
  const faint = Math.hypot(right, down) < 0.3;
  if (faint) return [drawing("circle", { class: name, r: 4, opacity: away > 0 ? 0.6 : 1 })];
  const text = drawing("text", { class: name, x: 1.5 * x, y: 1.5 * y });
  text.textContent = name;
  return [drawing("path", { class: name, d: `M0 0L${x} ${y}` }), text];
}
