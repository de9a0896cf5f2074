// SPDX-License-Identifier: Apache-2.0
// Nine parallel planes: where each lies, and the controls for their direction and distance.
import { element, find } from "./element";
import type { SettingsEditor } from "./settings_editor";

export const kTomography = "tomography";
export const kAcross = 3;
const kMiddle = 4;
const [kPlane, kStep] = ["slice.plane", "slice.step_mm"];
const kTitles = ["A", "B", "C", "Plane"];

/** How far the pane's plane is from the target, mm; panes are numbered along the rows. */
export function offsetMm(pane: number, stepMm: number): number {
  return Math.round(1000 * (pane - kMiddle) * stepMm) / 1000;
}

/** "C +10 mm". */
export function paneTitle(plane: number, pane: number, stepMm: number): string {
  const offset = offsetMm(pane, stepMm);
  const sign = offset > 0 ? "+" : offset < 0 ? "\u2212" : "";
  return `${kTitles[plane] ?? ""} ${sign}${Math.abs(offset)} mm`;
}

export class Tomography {
  private readonly root = find("#tomography", HTMLFieldSetElement);
  private readonly plane = find("#tomography-plane", HTMLSelectElement);
  private readonly step = find("#tomography-step", HTMLSelectElement);
  private readonly names = find("#tomography-names", HTMLElement);

  constructor(private readonly editor: Pick<SettingsEditor, "set" | "number" | "choice">) {
    this.plane.onchange = () => this.editor.set([[kPlane, Number(this.plane.value)]]);
    this.step.onchange = () => this.editor.set([[kStep, Number(this.step.value)]]);
  }

  /** Whether this display may change the planes. */
  allow(may: boolean): void {
    this.root.disabled = !may;
  }

  /** After a change of the scene. */
  refresh(): void {
    const shows = this.editor.choice("mode") === kTomography;
    this.root.hidden = this.names.hidden = !shows;
    if (!shows) return;
    this.plane.value = String(this.editor.number(kPlane));
    this.step.value = String(this.editor.number(kStep)); // empty where it is none of those
    this.names.replaceChildren(...this.titles().map((textContent) => element("span", { textContent })));
  }

  /** The titles of the panes; none in other modes. */
  titles(): string[] {
    if (this.editor.choice("mode") !== kTomography) return [];
    const [plane, step] = [this.editor.number(kPlane), this.editor.number(kStep)];
    return Array.from({ length: kAcross ** 2 }, (_, pane) => paneTitle(plane, pane, step));
  }
}
