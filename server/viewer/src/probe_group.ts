// SPDX-License-Identifier: Apache-2.0
// The settings of the probe, among those of the scene; hidden if the source is not a probe.
import { equals } from "@bufbuild/protobuf";
import { ProbeStatus_State, SceneFieldSchema, type ProbeStatus, type SceneField } from "../generated/fanlight_pb.js";
import { element } from "./element";
import { rangeText } from "./field_text";
import { numberBox, sliderOf } from "./number_inputs";
import { kProbeTitles, probeFields, probeValues, settingsText, whyReadOnly } from "./probe_settings";
import type { SettingsEditor } from "./settings_editor";

const kIdentity = { model: "Model", serial: "Serial number", firmware: "Firmware" } as const;

export class ProbeGroup {
  readonly root = element("details", { className: "group", hidden: true });
  private readonly note = element("span", { className: "note" });
  private readonly reason = element("p", { id: "probe-reason", className: "needs" });
  private readonly identity = element("dl", { className: "identity" });
  private readonly rows = element("div", { className: "rows" });
  private status: ProbeStatus | undefined;
  private fields: SceneField[] = [];
  private refreshers: (() => void)[] = [];

  constructor(private readonly editor: SettingsEditor) {
    this.root.dataset.group = "probe";
    const summary = element("summary", {}, element("h2", { textContent: "Probe" }), this.note);
    this.root.append(summary, this.identity, this.reason, this.rows);
  }

  /** Call at the start of a session; its ProbeStatus says whether its source is a probe. */
  forget(): void {
    this.status = undefined;
    this.editor.stop();
  }

  tell(status: ProbeStatus): void {
    const fields = probeFields(status);
    const known = this.status !== undefined && sameFields(fields, this.fields);
    this.status = status;
    if (known) {
      this.editor.adopt(0n, probeValues(status.settings));
    } else {
      this.fields = fields;
      this.refreshers = [];
      this.rows.replaceChildren(...fields.map((field) => this.row(field)));
      this.editor.start(fields, 0n, probeValues(status.settings));
    }
  }

  /** Shows the values of the editor, except in a box in which the user is typing. */
  refresh(): void {
    this.root.hidden = this.status === undefined || this.status.state === ProbeStatus_State.ABSENT;
    if (!this.status) return;
    const why = whyReadOnly(this.status);
    this.reason.textContent = why ?? "";
    this.reason.hidden = why === undefined;
    this.note.textContent = this.noteText(this.status);
    this.showIdentity(this.status);
    for (const refresher of this.refreshers) refresher();
  }

  private noteText({ state }: ProbeStatus): string {
    if (state === ProbeStatus_State.LOST) return "lost";
    if (this.editor.isChanging()) return "being set";
    return settingsText((name) => this.editor.number(name));
  }

  private showIdentity(status: ProbeStatus): void {
    const entries = Object.entries(kIdentity) as [keyof typeof kIdentity, string][];
    this.identity.replaceChildren(
      ...entries.flatMap(([key, title]) => {
        const text = element("dd", { textContent: status[key] || "–" });
        text.dataset.probe = key;
        return [element("dt", { textContent: title }), text];
      }),
    );
  }

  private row(field: SceneField): HTMLElement {
    const { name, unit, help } = field;
    const title = kProbeTitles[name] ?? name;
    const set = (value: number) => {
      if (this.maySet()) this.editor.set([[name, value]]);
    };
    const value = () => this.editor.number(name);
    const box = numberBox(field, `Probe, ${title.toLowerCase()}`, value, set);
    const slider = sliderOf(field, Infinity);
    slider.setAttribute("aria-describedby", `probe-reason ${name}-hint`);
    // A drag sends its last value only, because a probe moves its motor for each value.
    slider.oninput = () => {
      box.input.value = slider.value;
    };
    slider.onchange = () => set(slider.valueAsNumber);
    this.refreshers.push(() => {
      box.show();
      slider.value = String(value());
      box.input.readOnly = slider.disabled = !this.maySet();
    });
    const label = element("label", { htmlFor: name }, title, element("span", { className: "unit", textContent: unit }));
    const hint = element("p", { id: `${name}-hint`, className: "hint", textContent: `${help}; ${rangeText(field)}` });
    return element("div", { className: "row" }, label, box.input, slider, hint);
  }

  private maySet(): boolean {
    return this.status !== undefined && whyReadOnly(this.status) === undefined;
  }
}

function sameFields(a: readonly SceneField[], b: readonly SceneField[]): boolean {
  return a.length === b.length && a.every((field, index) => equals(SceneFieldSchema, field, b[index]!));
}
