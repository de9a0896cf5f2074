// SPDX-License-Identifier: Apache-2.0
// The titles of four panes and of nine planes, over the picture; stills have them too.
import { element, find } from "./element";
import { isTurned } from "./plane_turn";
import { kAcross, kTomography, paneTitle } from "./tomography";
import type { Turn } from "./view_geometry";

/** Of the picture shown. */
export interface TitledPlanes {
  mode: string;
  turn: Turn;
  /** Mode tomography: index of the direction of the planes, and their distance. */
  plane: number;
  stepMm: number;
}

export class PaneTitles {
  private readonly panes = find("#pane-names", HTMLElement);
  private readonly nine = find("#tomography-names", HTMLElement);
  private readonly ofPlanes = [...this.panes.querySelectorAll("span")].slice(0, 3);
  private readonly straight = this.ofPlanes.map(({ textContent }) => textContent);

  show({ mode, turn, plane, stepMm }: TitledPlanes): void {
    this.panes.hidden = mode !== "slices";
    this.nine.hidden = mode !== kTomography;
    for (const [index, title] of this.ofPlanes.entries()) {
      title.textContent = isTurned(turn) ? `${"ABC"[index]} (turned)` : this.straight[index]!;
    }
    const titles = Array.from({ length: kAcross ** 2 }, (_, pane) => paneTitle(plane, pane, stepMm, turn));
    this.nine.replaceChildren(
      ...(this.nine.hidden ? [] : titles.map((textContent) => element("span", { textContent }))),
    );
  }
}
