// The settings: a row for each field that the server offers.
import type { SceneField } from "../generated/fanlight_pb.js";
import { groupOf, hintOf, labelOf, numberText, sliderRange } from "./field_text";
import type { Values } from "./scene";
import type { SceneEditor } from "./scene_editor";

/** These stand on top under these names, before the fields of no group. */
const kMain = new Map([
  ["detector.threshold", "Threshold"],
  ["filter.size", "Filter size"],
  ["shadow.coefficient", "Shadow coefficient"],
]);

export class Controls {
  private readonly refreshers: (() => void)[] = [];

  constructor(
    form: HTMLFormElement,
    private readonly editor: SceneEditor,
    fields: SceneField[],
    private readonly defaults: Values,
  ) {
    form.onsubmit = (event) => event.preventDefault();
    const isMain = (field: SceneField) => kMain.has(field.name) || groupOf(field.name) === "";
    form.replaceChildren(this.mainSection(fields.filter(isMain)));
    const others = fields.filter((field) => !isMain(field));
    for (const group of new Set(others.map((field) => groupOf(field.name)))) {
      form.append(
        this.groupSection(
          group,
          others.filter((field) => groupOf(field.name) === group),
        ),
      );
    }
    this.refresh();
  }

  /** Shows the editor's values, except in a number box that is being typed into. */
  refresh(): void {
    for (const refresh of this.refreshers) refresh();
  }

  private mainSection(fields: SceneField[]): HTMLElement {
    const section = element("section", { className: "main" });
    const heading = element("div", { className: "heading" });
    heading.append(
      element("h2", { textContent: "Picture" }),
      this.resetButton("Reset all", [...this.defaults.keys()], "all"),
    );
    const sorted = [...fields].sort((a, b) => Number(kMain.has(b.name)) - Number(kMain.has(a.name)));
    section.append(heading, this.rows(sorted));
    return section;
  }

  private groupSection(group: string, fields: SceneField[]): HTMLElement {
    const details = element("details", {});
    details.dataset.group = group;
    details.append(
      element("summary", { textContent: labelOf(group) }),
      this.resetButton(
        `Reset ${group}`,
        fields.map((field) => field.name),
        group,
      ),
      this.rows(fields),
    );
    return details;
  }

  private rows(fields: SceneField[]): HTMLElement {
    const rows = element("div", { className: "rows" });
    rows.append(...fields.map((field) => this.row(field)));
    return rows;
  }

  private row(field: SceneField): HTMLElement {
    const row = element("div", { className: "row" });
    const label = element("label", { textContent: kMain.get(field.name) ?? labelOf(field.name), htmlFor: field.name });
    label.append(element("span", { className: "unit", textContent: field.unit }));
    const hint = element("p", {
      id: `${field.name}-hint`,
      className: "hint",
      textContent: hintOf(field, this.defaults.get(field.name) ?? NaN),
    });
    const reset = this.resetButton("↺", [field.name], field.name);
    reset.title = `Reset ${fullName(field)}`;
    reset.setAttribute("aria-label", reset.title);
    this.refreshers.push(() => {
      reset.disabled = this.editor.get(field.name) === this.defaults.get(field.name);
    });
    const inputs = field.choices.length > 0 ? [this.select(field)] : [this.numberBox(field), this.slider(field)];
    row.append(label, ...inputs, reset, hint);
    return row;
  }

  private slider(field: SceneField): HTMLElement {
    const { low, high, step } = sliderRange(field, this.defaults.get("camera.field_mm") ?? NaN);
    const slider = element("input", {
      type: "range",
      id: field.name,
      min: String(low),
      max: String(high),
      step: String(step),
    });
    slider.dataset.field = field.name;
    slider.setAttribute("aria-describedby", `${field.name}-hint`);
    slider.oninput = () => this.editor.set([[field.name, slider.valueAsNumber]]);
    this.refreshers.push(() => {
      slider.value = String(this.editor.get(field.name));
    });
    return slider;
  }

  private numberBox(field: SceneField): HTMLElement {
    const input = element("input", {
      type: "number",
      step: field.step > 0 ? String(field.step) : "any",
      min: String(field.minimum),
      max: String(field.maximum),
    });
    input.dataset.number = field.name;
    input.setAttribute("aria-label", `${fullName(field)}, ${field.unit || "number"}`);
    let typing = false;
    const show = () => {
      if (!typing) input.value = numberText(this.editor.get(field.name));
    };
    input.oninput = () => {
      typing = true;
    };
    input.onchange = () => {
      typing = false;
      if (Number.isFinite(input.valueAsNumber)) this.editor.set([[field.name, input.valueAsNumber]]);
      else show();
    };
    // Typed and taken back is no change, but the box is free again.
    input.onblur = () => {
      typing = false;
      show();
    };
    this.refreshers.push(show);
    return input;
  }

  private select(field: SceneField): HTMLElement {
    const select = element("select", { id: field.name });
    select.dataset.field = field.name;
    select.setAttribute("aria-describedby", `${field.name}-hint`);
    select.append(...field.choices.map((choice, index) => new Option(choice.replace(/-/g, " "), String(index))));
    select.onchange = () => this.editor.set([[field.name, Number(select.value)]]);
    this.refreshers.push(() => {
      select.value = String(this.editor.get(field.name));
    });
    return select;
  }

  private resetButton(text: string, names: string[], scope: string): HTMLButtonElement {
    const button = element("button", { type: "button", className: "reset", textContent: text });
    button.dataset.reset = scope;
    button.onclick = () => this.editor.set(names.map((name) => [name, this.defaults.get(name) ?? NaN] as const));
    return button;
  }
}

function fullName(field: SceneField): string {
  return `${groupOf(field.name)} ${labelOf(field.name).toLowerCase()}`.trim();
}

function element<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Partial<HTMLElementTagNameMap[Tag]>,
): HTMLElementTagNameMap[Tag] {
  return Object.assign(document.createElement(tag), properties);
}
