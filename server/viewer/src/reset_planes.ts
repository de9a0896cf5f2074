// SPDX-License-Identifier: Apache-2.0
// The button that turns the planes A, B and C back along the sweep; seen while the picture shows turned ones.
import { find } from "./element";
import { isTurned, planeTurn, turnValues } from "./plane_turn";
import type { SettingsEditor } from "./settings_editor";
import { followsCamera, kPlane, kTomography } from "./tomography";

export class ResetPlanes {
  private readonly button = find("#reset-planes", HTMLButtonElement);

  constructor(private readonly editor: Pick<SettingsEditor, "set" | "number" | "choice">) {
    this.button.onclick = () => this.editor.set(turnValues({ yawDeg: 0, pitchDeg: 0, rollDeg: 0 }));
  }

  /** Whether this display may change the planes. */
  allow(may: boolean): void {
    this.button.disabled = !may;
  }

  /** After a change of the scene. */
  refresh(): void {
    const mode = this.editor.choice("mode");
    const shows = mode === "slices" || (mode === kTomography && !followsCamera(this.editor.number(kPlane)));
    this.button.hidden = !shows || !isTurned(planeTurn(this.editor));
  }
}
