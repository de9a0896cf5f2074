// SPDX-License-Identifier: Apache-2.0
// The handle on the line across a pane. It turns the picture of the pane about its middle; the other planes follow.
import { drawing } from "./element";
import type { Pane } from "./plane_geometry";
import type { Drag } from "./plane_overlay";
import { angleAbout, turnedInPane } from "./plane_turn";
import type { Turn } from "./view_geometry";

const kRadius = 0.4; // of the pane's shorter side
const kKeyStepRad = Math.PI / 180;

/** `before`: the turn of the planes when the handle is drawn. `turned` takes the new one. */
export function turnHandle(pane: Pane, before: Turn, turned: (turn: Turn) => void): { handle: SVGElement; drag: Drag } {
  const { left, top, width, height } = pane.part;
  const middle = { x: left + width / 2, y: top + height / 2 };
  const radius = kRadius * Math.min(width, height);
  const at = { x: middle.x + radius, y: middle.y };
  const title = drawing("title", {}, `Drag to turn plane ${pane.name}`);
  const handle = drawing("circle", { class: "turn", cx: at.x, cy: at.y }, title);
  const turnBy = (rad: number) => turned(turnedInPane(before, pane, rad));
  const drag: Drag = {
    moved: (way) => {
      const rad = angleAbout(middle, at, { x: at.x + way.x, y: at.y + way.y });
      handle.setAttribute("cx", String(middle.x + radius * Math.cos(rad)));
      handle.setAttribute("cy", String(middle.y - radius * Math.sin(rad)));
      turnBy(rad);
    },
    // Left and up turn to the left, as the picture turns with the handle.
    keyed: (way, steps) => turnBy((way.x < 0 || way.y < 0 ? 1 : -1) * steps * kKeyStepRad),
  };
  return { handle, drag };
}
