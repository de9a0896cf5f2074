// SPDX-License-Identifier: Apache-2.0
// The choice of what a drag over the picture does.

export type Tool = "light" | "orbit" | "pan" | "measure" | "crop" | "cut" | "note";

export class Tools {
  private wanted: Tool;
  private readonly inputs: HTMLInputElement[];

  constructor(
    fieldset: HTMLFieldSetElement,
    private readonly canvas: HTMLCanvasElement,
    private readonly changed: (tool: Tool) => void,
  ) {
    this.inputs = [...fieldset.querySelectorAll("input")];
    this.wanted = this.chosen();
    fieldset.onchange = () => {
      this.wanted = this.chosen();
      this.show();
    };
    this.canvas.dataset.tool = this.chosen();
  }

  chosen(): Tool {
    return (this.inputs.find((input) => input.checked)?.value ?? "orbit") as Tool;
  }

  choose(tool: Tool): void {
    const input = this.input(tool);
    if (input.disabled) return;
    input.checked = true;
    this.wanted = tool;
    this.show();
  }

  /** In modes that light nothing the light cannot be moved. The user's choice returns with the light. */
  offerLight(lit: boolean): void {
    const light = this.input("light");
    if (light.disabled === !lit) return;
    light.disabled = !lit;
    if (this.wanted !== "light") return;
    (lit ? light : this.input("orbit")).checked = true;
    this.show();
  }

  private input(tool: Tool): HTMLInputElement {
    const found = this.inputs.find((input) => input.value === tool);
    if (!found) throw new Error(`The page has no tool ${tool}.`);
    return found;
  }

  private show(): void {
    this.canvas.dataset.tool = this.chosen();
    this.changed(this.chosen());
  }
}
