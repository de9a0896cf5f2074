// SPDX-License-Identifier: Apache-2.0
// A cross over the picture that keys move and click with, for tools that need a place: measure, scalpel and note.
import { element } from "./element";
import type { PagePoint } from "./view_geometry";

const kStepShare = 0.01; // of the picture's width and height
const kLargeSteps = 8;

const kLine = "linear-gradient(#fff, #fff) center /";
const kStyle = {
  position: "absolute",
  width: "26px",
  height: "26px",
  translate: "-50% -50%",
  pointerEvents: "none",
  background: `${kLine} 2px 100% no-repeat, ${kLine} 100% 2px no-repeat`,
  filter: "drop-shadow(0 0 1px #000)",
};

export class KeyCursor {
  private readonly cross = element("div", { id: "key-cursor", hidden: true });
  private at = { x: 0.5, y: 0.5 }; // shares of the picture's width and height

  constructor(
    private readonly frame: HTMLElement,
    private readonly clicked: (pointer: PagePoint) => void,
  ) {
    this.cross.ariaHidden = "true";
    Object.assign(this.cross.style, kStyle); // of the page and of shared files
    frame.append(this.cross);
  }

  /** The picture has lost the focus, another tool was chosen, or a pointer is used. */
  hide(): void {
    this.cross.hidden = true;
  }

  /** Moves the cross by steps to the right and up. The first key shows it where it was. */
  move(right: number, up: number, isLarge: boolean): void {
    const step = kStepShare * (isLarge ? kLargeSteps : 1);
    const within = (share: number) => Math.min(1, Math.max(0, share));
    if (!this.cross.hidden) this.at = { x: within(this.at.x + right * step), y: within(this.at.y - up * step) };
    this.cross.hidden = false;
    this.cross.style.left = `${100 * this.at.x}%`;
    this.cross.style.top = `${100 * this.at.y}%`;
  }

  /** Clicks where the cross is; without one, shows it. */
  click(): void {
    if (this.cross.hidden) return this.move(0, 0, false);
    const shown = this.frame.getBoundingClientRect();
    this.clicked({ x: shown.left + this.at.x * shown.width, y: shown.top + this.at.y * shown.height });
  }
}
