// SPDX-License-Identifier: Apache-2.0
// The thickness of the planes, where the picture shows some, and the mark that says it.
import { find } from "./element";
import type { SettingsEditor } from "./settings_editor";

const [kThickness, kKind] = ["slice.slab_mm", "slice.slab"];
const kPlaneModes = ["slice", "slices", "tomography"];
const kKinds = ["Mean", "Maximum", "X-ray"];

/** "Planes: mean of 10 mm"; empty: thin planes. */
export function slabText(thicknessMm: number, kind: number): string {
  return thicknessMm > 0 ? `Planes: ${kKinds[kind] ?? "slab"} of ${thicknessMm} mm` : "";
}

export class SlabControl {
  private readonly root = find("#slab", HTMLFieldSetElement);
  private readonly thickness = find("#slab-mm", HTMLSelectElement);
  private readonly kind = find("#slab-kind", HTMLSelectElement);
  private readonly mark = find("#slab-mark", HTMLElement);

  constructor(private readonly editor: Pick<SettingsEditor, "set" | "number" | "choice">) {
    this.thickness.onchange = () => this.editor.set([[kThickness, Number(this.thickness.value)]]);
    this.kind.onchange = () => this.editor.set([[kKind, Number(this.kind.value)]]);
  }

  /** Whether this display may change it. */
  allow(may: boolean): void {
    this.root.disabled = !may;
  }

  /** After a change of the scene. */
  refresh(): void {
    const thicknessMm = this.editor.number(kThickness);
    const shows = kPlaneModes.includes(this.editor.choice("mode"));
    this.root.hidden = !shows;
    this.kind.hidden = !(thicknessMm > 0);
    this.thickness.value = String(thicknessMm); // empty where it is none of those
    this.kind.value = String(this.editor.number(kKind));
    this.mark.textContent = shows ? slabText(thicknessMm, this.editor.number(kKind)) : "";
    this.mark.hidden = this.mark.textContent === "";
  }
}
