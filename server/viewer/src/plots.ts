// SPDX-License-Identifier: Apache-2.0
// Small plots of the last minute, behind the statistics button.
import { drawing, element } from "./element";

const kMost = 240; // values, four a second
const kWidth = 240;
const kHeight = 40;

export class Plot {
  readonly root: HTMLElement;
  private readonly values: number[] = [];
  private readonly line = drawing("polyline", {});
  private readonly most = element("span", {});

  constructor(
    title: string,
    private readonly unit: string,
  ) {
    const plot = drawing("svg", { viewBox: `0 0 ${kWidth} ${kHeight}`, preserveAspectRatio: "none" }, this.line);
    this.root = element("figure", {}, element("figcaption", {}, `${title}, last minute`, this.most), plot);
  }

  add(value: number | undefined): void {
    if (value === undefined || !Number.isFinite(value)) return;
    this.values.push(value);
    if (this.values.length > kMost) this.values.shift();
  }

  draw(): void {
    const top = Math.max(...this.values, 1e-9);
    this.most.textContent = this.values.length > 0 ? `up to ${rounded(top)} ${this.unit}` : "";
    this.line.setAttribute("points", linePoints(this.values, top));
  }
}

/** The newest value at the right edge. */
export function linePoints(values: readonly number[], top: number): string {
  const x = (index: number) => kWidth - ((values.length - 1 - index) * kWidth) / (kMost - 1);
  const y = (value: number) => kHeight - 2 - ((kHeight - 4) * value) / top;
  return values.map((value, index) => `${x(index).toFixed(1)},${y(value).toFixed(1)}`).join(" ");
}

function rounded(value: number): string {
  return value >= 10 ? value.toFixed(0) : value.toFixed(1);
}
