// SPDX-License-Identifier: Apache-2.0
// The presets, the number of panes, and the views from each side: buttons that set several fields at once.
import type { Look } from "../generated/fanlight_pb.js";
import { element } from "./element";
import { valuesOf, type Values } from "./scene";
import type { SettingsEditor } from "./settings_editor";

export class PresetBar {
  private builtIn: readonly Look[] = [];
  private presets: readonly Look[] = [];

  constructor(
    private readonly root: HTMLFieldSetElement,
    private readonly editor: SettingsEditor,
    /** Values of the surface that was found. */
    private readonly found: () => Values,
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

  /** Sets what the search for the surface found. Bone and Fluid keep what they look for, and take the view. */
  setFound(found: Values): void {
    const isOwn = this.builtIn.some((preset) => preset.foundFields.length === 0 && this.holds(preset));
    const kept = isOwn ? this.builtIn.flatMap(({ foundFields }) => foundFields) : [];
    // It comes some time after the hand that asked for it, and is no part of what the hand does now.
    this.editor.set(
      [...found].filter(([name]) => !kept.includes(name)),
      {},
    );
  }

  refresh(): void {
    // Several may hold at once: one that was saved is like one of the server.
    const held = new Set(this.presets.filter((preset) => this.holds(preset)).map(({ name }) => name));
    for (const button of this.root.querySelectorAll("button")) button.ariaPressed = String(held.has(button.value));
  }

  private button(preset: Look): HTMLButtonElement {
    const { name, help } = preset;
    const button = element("button", { type: "button", value: name, textContent: name, title: help });
    if (this.builtIn.includes(preset)) button.dataset.preset = name;
    button.onclick = () => this.editor.set(this.valuesOf(preset));
    return button;
  }

  private holds(preset: Look): boolean {
    return [...this.valuesOf(preset)].every(([name, value]) => this.editor.get(name) === value);
  }

  private valuesOf({ scene, foundFields }: Look): Values {
    const values = scene ? valuesOf(scene) : new Map();
    const found = this.found();
    for (const name of foundFields) if (found.has(name)) values.set(name, found.get(name)!);
    return values;
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
