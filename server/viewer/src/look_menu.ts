// SPDX-License-Identifier: Apache-2.0
// The menu of looks: a look sets several fields at once; they stay changeable one by one.
import type { Look } from "../generated/fanlight_pb.js";
import { element } from "./element";
import { valuesOf, type Values } from "./scene";
import type { SettingsEditor } from "./settings_editor";

const kOwn = "";

/** The name of the look whose fields the editor has, empty if none. */
export function lookOf(looks: readonly Look[], editor: SettingsEditor): string {
  const holds = (values: Values) => [...values].every(([name, value]) => editor.get(name) === value);
  return looks.find((look) => look.scene && holds(valuesOf(look.scene)))?.name ?? kOwn;
}

/** A row of the settings; undefined where the server offers no looks. */
export function lookRow(
  looks: readonly Look[],
  editor: SettingsEditor,
  onRefresh: (refresher: () => void) => void,
): HTMLElement | undefined {
  if (looks.length === 0) return undefined;
  const select = element("select", { id: "look" });
  const own = new Option("Own", kOwn, false, false);
  own.disabled = true; // shown where no look fits; there is nothing to choose
  select.append(...looks.map((look) => new Option(look.name[0]?.toUpperCase() + look.name.slice(1), look.name)), own);
  select.onchange = () => {
    const scene = looks.find((look) => look.name === select.value)?.scene;
    if (scene) editor.set(valuesOf(scene));
  };
  const hint = element("p", { id: "look-hint", className: "hint" });
  select.setAttribute("aria-describedby", hint.id);
  onRefresh(() => {
    select.value = lookOf(looks, editor);
    hint.textContent = looks.find((look) => look.name === select.value)?.help ?? "changed by hand";
  });
  return element("div", { className: "row" }, element("label", { htmlFor: "look", textContent: "Look" }), select, hint);
}
