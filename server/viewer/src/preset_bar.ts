// SPDX-License-Identifier: Apache-2.0
// The presets, the number of panes, and the views from each side: buttons that set several fields at once.
import type { Look } from "../generated/fanlight_pb.js";
import { element } from "./element";
import { lookOf } from "./look_menu";
import { valuesOf } from "./scene";
import type { SettingsEditor } from "./settings_editor";

export class PresetBar {
  private builtIn: readonly Look[] = [];
  private presets: readonly Look[] = [];

  constructor(
    private readonly root: HTMLFieldSetElement,
    private readonly editor: SettingsEditor,
  ) {}

  start(presets: readonly Look[]): void {
    this.builtIn = presets;
    this.show([]);
  }

  /** `saved`: those that people have saved on the server. */
  show(saved: readonly Look[]): void {
    this.presets = [...this.builtIn, ...saved];
    this.root.replaceChildren(...this.presets.map((preset) => this.button(preset)));
    this.refresh();
  }

  refresh(): void {
    // Several may hold at once: one that was saved is like one of the server.
    const holds = (preset: Look) => lookOf([preset], this.editor) === preset.name;
    const held = new Set(this.presets.filter(holds).map(({ name }) => name));
    for (const button of this.root.querySelectorAll("button")) button.ariaPressed = String(held.has(button.value));
  }

  private button(preset: Look): HTMLButtonElement {
    const { name, help, scene } = preset;
    const button = element("button", { type: "button", value: name, textContent: name, title: help });
    if (this.builtIn.includes(preset)) button.dataset.preset = name;
    button.onclick = () => scene && this.editor.set(valuesOf(scene));
    return button;
  }
}

/** How many panes: the field "mode". In other modes none is chosen. */
export class LayoutBar {
  private readonly inputs: HTMLInputElement[];

  constructor(
    root: HTMLFieldSetElement,
    private readonly editor: SettingsEditor,
  ) {
    this.inputs = [...root.querySelectorAll("input")];
    for (const input of this.inputs) input.onchange = () => this.choose(input.value);
  }

  choose(mode: string): void {
    const index = this.editor.choicesOf("mode").indexOf(mode);
    if (index >= 0) this.editor.set([["mode", index]]);
    this.refresh();
  }

  refresh(): void {
    for (const input of this.inputs) input.checked = input.value === this.editor.choice("mode");
  }
}

/** Buttons whose data-view is "YAW PITCH", in degrees. */
export function connectViews(root: HTMLElement, editor: Pick<SettingsEditor, "set">): void {
  for (const button of root.querySelectorAll("button")) {
    button.onclick = () => {
      const [yaw = 0, pitch = 0] = (button.dataset.view ?? "").split(" ").map(Number);
      editor.set([
        ["camera.yaw_deg", yaw],
        ["camera.pitch_deg", pitch],
        ["camera.roll_deg", 0],
      ]);
    };
  }
}
