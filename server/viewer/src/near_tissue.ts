// SPDX-License-Identifier: Apache-2.0
// The button "Remove near tissue", and the mark of a picture without it.
import { NearTissue } from "../generated/fanlight_pb.js";
import type { SettingsEditor } from "./settings_editor";

const kField = "near.tissue";
const [kShown, kRemoved] = [0, 1];

/** What the mark says; empty: nothing. */
export function nearTissueText(state: NearTissue): string {
  if (state === NearTissue.REMOVED) return "Near tissue removed";
  if (state === NearTissue.NOT_FOUND) return "No fluid behind near tissue: nothing removed";
  if (state === NearTissue.REMOVED_TO_BONE) return "Removed up to the bone";
  if (state === NearTissue.NO_BONE) return "No closed bone found: nothing removed";
  return "";
}

export class NearTissueButton {
  constructor(
    private readonly button: HTMLButtonElement,
    private readonly mark: HTMLElement,
    private readonly editor: Pick<SettingsEditor, "set" | "number">,
  ) {
    button.onclick = () => editor.set([[kField, this.isOn() ? kShown : kRemoved]]);
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
    return this.editor.number(kField) === kRemoved;
  }
}
