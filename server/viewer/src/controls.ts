// SPDX-License-Identifier: Apache-2.0
// The settings: one section per group of the fields that the server offers, and one for the probe.
import type { Hello } from "../generated/fanlight_pb.js";
import { element } from "./element";
import type { FieldEffects } from "./field_effects";
import { groupOf } from "./field_text";
import { lookRow } from "./look_menu";
import type { MeasuredValues } from "./measured_values";
import type { Values } from "./scene";
import { SettingRows } from "./setting_rows";
import type { SettingsEditor } from "./settings_editor";
import { namesOf, sections, type Section } from "./settings_layout";

export class Controls {
  private readonly rows: SettingRows;
  private offered: readonly string[] | undefined;

  constructor(
    form: HTMLFormElement,
    private readonly editor: SettingsEditor,
    private readonly effects: FieldEffects,
    private readonly hello: Pick<Hello, "fields" | "looks">,
    private readonly defaults: Values,
    probe: HTMLElement,
    measured: MeasuredValues,
  ) {
    this.rows = new SettingRows(editor, defaults, effects, measured);
    form.onsubmit = (event) => event.preventDefault();
    const [main, ...groups] = sections(hello.fields);
    form.replaceChildren(
      ...(main ? [this.mainSection(main)] : []),
      probe,
      ...groups.map((group) => this.groupSection(group)),
    );
    this.refresh();
  }

  refresh(): void {
    this.rows.refresh();
  }

  /** Makes only these groups editable; absent: all. */
  limitTo(groups: readonly string[] | undefined): void {
    this.offered = groups;
    this.refresh();
  }

  private isOffered(group: string): boolean {
    return this.offered?.includes(group) ?? true;
  }

  /** Hides a row of the first section while its group has no effect. In the other sections such rows stay visible. */
  private mainSection({ title, settings }: Section): HTMLElement {
    const heading = element("div", { className: "heading" }, element("h2", { textContent: title }));
    const reset = this.rows.resetButton("Reset all", [...this.defaults.keys()], "all");
    this.rows.onRefresh(() => (reset.inert = this.offered !== undefined));
    heading.append(reset);
    const rows = element("div", { className: "rows" });
    const look = lookRow(this.hello.looks, this.editor, (refresher) => this.rows.onRefresh(refresher));
    if (look) {
      this.rows.onRefresh(() => (look.hidden = this.effects.missing("light") !== undefined));
      rows.append(look);
    }
    for (const setting of settings) {
      const row = this.rows.row(setting);
      const names = namesOf(setting);
      this.rows.onRefresh(() => {
        row.hidden = names.some((name) => this.effects.missing(groupOf(name)) !== undefined);
        row.inert = !names.every((name) => this.isOffered(groupOf(name)));
      });
      rows.append(row);
    }
    return element("section", { className: "main" }, heading, rows);
  }

  private groupSection({ group, title, settings }: Section): HTMLElement {
    const names = settings.flatMap(namesOf);
    const note = element("span", { className: "note" });
    const needs = element("p", { className: "needs" });
    const reset = this.rows.resetButton("Reset", names, group);
    reset.setAttribute("aria-label", `Reset ${title.toLowerCase()}`);
    const details = element("details", { className: "group" });
    details.dataset.group = group;
    details.append(
      element("summary", {}, element("h2", { textContent: title }), note),
      reset,
      needs,
      element("div", { className: "rows" }, ...settings.map((setting) => this.rows.row(setting))),
    );
    this.rows.onRefresh(() => {
      const missing = this.effects.missing(group);
      const changed = this.rows.changed(names);
      details.classList.toggle("idle", missing !== undefined);
      for (const part of details.children)
        (part as HTMLElement).inert = part.tagName !== "SUMMARY" && !this.isOffered(group);
      needs.textContent = missing ?? "";
      needs.hidden = missing === undefined;
      note.textContent = missing ? "unused" : changed > 0 ? `${changed} changed` : "";
    });
    return details;
  }
}
