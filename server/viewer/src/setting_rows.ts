// SPDX-License-Identifier: Apache-2.0
// Rows of the settings: number, choice, text or colour, each with its description and a reset button.
import type { SceneField } from "../generated/fanlight_pb.js";
import { hexOf, partsOf } from "./colour";
import { element, typedBox } from "./element";
import type { FieldEffects } from "./field_effects";
import { choiceText, hintOf } from "./field_text";
import { kMeasuredFields, type MeasuredValues } from "./measured_values";
import { numberBox, sliderOf } from "./number_inputs";
import { numberOf, type Value, type Values } from "./scene";
import type { SettingsEditor } from "./settings_editor";
import { fullTitle, namesOf, rowTitle, type ColourSetting, type Setting } from "./settings_layout";

interface Frame {
  name: string;
  title: string;
  unit: string;
  hint: string;
  names: string[]; // of the fields in the row
}

export class SettingRows {
  private readonly refreshers: (() => void)[] = [];

  constructor(
    private readonly editor: SettingsEditor,
    private readonly defaults: Values,
    private readonly effects: FieldEffects,
    private readonly measured: MeasuredValues,
  ) {}

  /** `refresher` runs at every change of the scene. */
  onRefresh(refresher: () => void): void {
    this.refreshers.push(refresher);
  }

  /** Shows the values of the editor, except in a box in which the user is typing. */
  refresh(): void {
    for (const refresher of this.refreshers) refresher();
  }

  row(setting: Setting): HTMLElement {
    if (setting.kind === "colour") return this.colourRow(setting);
    const { field } = setting;
    const { name, unit } = field;
    const hint = hintOf(field, this.defaults.get(name) ?? NaN);
    const frame = { name, title: rowTitle(name), unit, hint, names: [name] };
    if (name === "transfer.points") return this.frame(frame, this.transferEditor(name), this.textBox(name));
    if (field.isText) return this.frame(frame, this.textBox(name));
    if (field.choices.length > 0) return this.frame(frame, this.select(field));
    return this.frame(frame, this.numberBox(field), this.slider(field), ...this.measurement(name));
  }

  /** For a field that may ask for values from the data: the value in force, and a button that keeps it. */
  private measurement(name: string): HTMLElement[] {
    if (!kMeasuredFields.includes(name)) return [];
    const text = element("span", { className: "measured-text" });
    const keep = element("button", { type: "button", className: "keep", textContent: "Keep" });
    keep.dataset.keep = name;
    keep.title = "Set this value for all following volumes";
    keep.onclick = () => this.editor.set([[name, this.measured.valueOf(name) ?? 0]]);
    const line = element("p", { className: "measured" }, text, keep);
    this.onRefresh(() => {
      text.textContent = this.measured.text(name);
      line.hidden = text.textContent === "";
    });
    return [line];
  }

  resetButton(text: string, names: readonly string[], scope: string): HTMLButtonElement {
    const button = element("button", { type: "button", className: "reset", textContent: text });
    button.dataset.reset = scope;
    const inMm = names.map((name) => `${name}_mm`).filter((name) => this.defaults.has(name));
    const all = [...new Set([...names, ...inMm])]; // what counts samples would set the one in mm to 0
    button.onclick = () => this.editor.set(all.map((name) => [name, this.defaultOf(name)] as const));
    this.onRefresh(() => {
      button.disabled = this.changed(names) === 0;
    });
    return button;
  }

  /** How many of these fields differ from their default. */
  changed(names: readonly string[]): number {
    return names.filter((name) => this.editor.get(name) !== this.defaults.get(name)).length;
  }

  private frame({ name, title, unit, hint, names }: Frame, ...inputs: HTMLElement[]): HTMLElement {
    const label = element("label", { htmlFor: name }, title, element("span", { className: "unit", textContent: unit }));
    const reset = this.resetButton("↺", names, name);
    reset.title = `Reset ${fullTitle(name)}`;
    reset.setAttribute("aria-label", reset.title);
    const needs = element("p", { id: `${name}-needs`, className: "needs" });
    const row = element("div", { className: "row" }, label, ...inputs, reset, needs);
    row.append(element("p", { id: `${name}-hint`, className: "hint", textContent: hint }));
    row.querySelector(`[id="${name}"]`)?.setAttribute("aria-describedby", `${name}-needs ${name}-hint`);
    this.onRefresh(() => {
      const missing = this.effects.missing(name);
      row.classList.toggle("idle", missing !== undefined);
      needs.textContent = missing ?? "";
      needs.hidden = missing === undefined;
    });
    return row;
  }

  private slider(field: SceneField): HTMLElement {
    const slider = sliderOf(field, numberOf(this.defaults.get("camera.field_mm")));
    slider.oninput = () => this.editor.set([[field.name, slider.valueAsNumber]]);
    this.onRefresh(() => {
      slider.value = String(this.measured.valueOf(field.name) ?? this.editor.number(field.name));
    });
    return slider;
  }

  private numberBox(field: SceneField): HTMLElement {
    const value = () => this.editor.number(field.name);
    const take = (typed: number) => this.editor.set([[field.name, typed]]);
    const { input, show } = numberBox(field, fullTitle(field.name), value, take, () =>
      this.measured.valueOf(field.name),
    );
    this.onRefresh(show);
    return input;
  }

  private textBox(name: string): HTMLElement {
    const input = element("input", { type: "text", id: name, spellcheck: false });
    input.dataset.text = name;
    const take = () => this.editor.set([[name, input.value]]);
    this.onRefresh(typedBox(input, () => this.editor.text(name), take));
    return input;
  }

  private select(field: SceneField): HTMLElement {
    const select = element("select", { id: field.name });
    select.dataset.field = field.name;
    select.append(...field.choices.map((choice, index) => new Option(choiceText(choice), String(index))));
    select.onchange = () => this.editor.set([[field.name, Number(select.value)]]);
    this.onRefresh(() => {
      select.value = String(this.editor.number(field.name));
    });
    return select;
  }

  private colourRow(setting: ColourSetting): HTMLElement {
    const { name, parts } = setting;
    const names = namesOf(setting);
    const input = element("input", { type: "color", id: name });
    input.dataset.colour = name;
    input.oninput = () => {
      const levels = partsOf(input.value);
      this.editor.set(names.map((part, index) => [part, levels[index] ?? NaN] as const));
    };
    this.onRefresh(() => {
      input.value = hexOf(names.map((part) => this.editor.number(part)));
    });
    const numbers = element("details", { className: "parts" }, element("summary", { textContent: "Red, green, blue" }));
    numbers.append(...parts.map((field) => this.row({ kind: "field", field })));
    const meaning = parts[0].help.replace(/, red$/, "");
    const hint = `${meaning}; default ${hexOf(names.map((part) => numberOf(this.defaults.get(part))))}`;
    const row = this.frame({ name, title: rowTitle(name), unit: "", hint, names }, input);
    row.append(numbers);
    return row;
  }

  /** Loaded when it is first seen: few users open it. */
  private transferEditor(name: string): HTMLElement {
    const place = element("div", {});
    const load = async () => {
      const { TransferEditor } = (await import("./transfer_editor.js")) as typeof import("./transfer_editor");
      const transfer = new TransferEditor((text) => this.editor.set([[name, text]]));
      place.replaceWith(transfer.root);
      const show = () => transfer.show(this.editor.text(name));
      this.onRefresh(show);
      show();
    };
    const seen = new IntersectionObserver((entries) => {
      if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
      seen.unobserve(place);
      load().catch(() => {
        place.textContent = "The curve could not be loaded from the server. Close and open this section to try again.";
        seen.observe(place);
      });
    });
    seen.observe(place);
    return place;
  }

  private defaultOf(name: string): Value {
    return this.defaults.get(name) ?? NaN;
  }
}
