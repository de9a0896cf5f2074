// SPDX-License-Identifier: Apache-2.0
// The button "Remove near tissue", and the mark of a picture without it.
import { NearTissue } from "../generated/fanlight_pb.js";
import type { SettingsEditor } from "./settings_editor";

const [kToFluid, kToBone] = ["near.tissue", "near.before_bone"];
const [kShown, kRemoved] = [0, 1];

/** What the mark says; empty: nothing. */
export function nearTissueText(state: NearTissue): string {
  if (state === NearTissue.REMOVED) return "Near tissue removed";
  if (state === NearTissue.NOT_FOUND) return "No fluid behind near tissue: nothing removed";
  if (state === NearTissue.REMOVED_TO_BONE) return "Removed up to the bone";
  if (state === NearTissue.NO_BONE) return "Neither skull nor fluid found: nothing removed";
  return "";
}

export class NearTissueButton {
  constructor(
    private readonly button: HTMLButtonElement,
    private readonly mark: HTMLElement,
    private readonly editor: Pick<SettingsEditor, "set" | "number">,
  ) {
    button.onclick = () => {
      if (!this.isOn()) return editor.set([[kToFluid, kRemoved]]);
      editor.set([
        [kToFluid, kShown],
        [kToBone, kShown],
      ]);
    };
  }

  /** After a change of the scene. */
  refresh(): void {
    this.button.ariaPressed = String(this.isOn());
  }

  showPicture(state: NearTissue): void {
    const text = nearTissueText(state);
    this.mark.textContent = text;
    this.mark.hidden = text === "";
  }

  private isOn(): boolean {
    return [kToFluid, kToBone].some((field) => this.editor.number(field) === kRemoved);
  }
}
