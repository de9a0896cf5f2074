// SPDX-License-Identifier: Apache-2.0
// The choice of what a drag over the picture moves: light or camera.

export type Tool = "light" | "orbit";

export class Tools {
  private wanted: Tool;
  private readonly light: HTMLInputElement;
  private readonly orbit: HTMLInputElement;

  constructor(
    fieldset: HTMLFieldSetElement,
    private readonly canvas: HTMLCanvasElement,
  ) {
    const input = (tool: Tool) => {
      const found = fieldset.querySelector<HTMLInputElement>(`input[value="${tool}"]`);
      if (!found) throw new Error(`The page has no tool ${tool}.`);
      return found;
    };
    this.light = input("light");
    this.orbit = input("orbit");
    this.wanted = this.chosen();
    fieldset.onchange = () => {
      this.wanted = this.chosen();
      this.show();
    };
    this.show();
  }

  chosen(): Tool {
    return this.orbit.checked ? "orbit" : "light";
  }

  /** In modes that light nothing only the camera can be moved. The user's choice returns with the light. */
  offerLight(lit: boolean): void {
    if (this.light.disabled === !lit) return;
    this.light.disabled = !lit;
    (lit && this.wanted === "light" ? this.light : this.orbit).checked = true;
    this.show();
  }

  private show(): void {
    this.canvas.dataset.tool = this.chosen();
  }
}
