// SPDX-License-Identifier: Apache-2.0
// The titles of the panes A, B and C, which say whether the planes are turned, and the button that turns them back.
import { find } from "./element";
import { isTurned, planeTurn, turnValues } from "./plane_turn";
import type { SettingsEditor } from "./settings_editor";

const kStraight = { yawDeg: 0, pitchDeg: 0, rollDeg: 0 };
const kModes = ["slices", "tomography"];

export class TurnedPlanes {
  private readonly button = find("#reset-planes", HTMLButtonElement);
  private readonly names = [...find("#pane-names", HTMLElement).querySelectorAll("span")].slice(0, 3);
  private readonly straight = this.names.map(({ textContent }) => textContent);

  constructor(private readonly editor: Pick<SettingsEditor, "set" | "number" | "choice">) {
    this.button.onclick = () => this.editor.set(turnValues(kStraight));
  }

  /** Whether this display may change the planes. */
  allow(may: boolean): void {
    this.button.disabled = !may;
  }

  /** After a change of the scene. */
  refresh(): void {
    const turned = isTurned(planeTurn(this.editor));
    this.button.hidden = !turned || !kModes.includes(this.editor.choice("mode"));
    for (const [index, name] of this.names.entries()) {
      name.textContent = turned ? `${"ABC"[index]} turned` : this.straight[index]!;
    }
  }
}
