// SPDX-License-Identifier: Apache-2.0
// The presets that people have saved on the server: save, remove, export and import, in the form of /api/scene.
import { create } from "@bufbuild/protobuf";
import {
  LookSchema,
  type Look,
  type PresetList,
  type PresetRequest,
  type Scene,
  type SceneField,
} from "../generated/fanlight_pb.js";
import { element } from "./element";
import { saveFile } from "./save_file";
import { sceneOf, valuesOf, type Value, type Values } from "./scene";
import type { SettingsEditor } from "./settings_editor";

const kMostFileBytes = 1_000_000;
// What a preset leaves as it is: see PresetStore of the server.
const kLeftAlone = ["camera", "rays", "crop", "cuts", "slice", "deadline"];

/** {"light": {"right_mm": -60}, "mode": "surface"}: choices by name. */
export function jsonOf(values: Values, fields: readonly SceneField[]): Record<string, unknown> {
  const json: Record<string, unknown> = {};
  for (const { name, choices } of fields) {
    const value = values.get(name);
    if (value === undefined) continue;
    const [group, part] = name.split(".") as [string, string | undefined];
    const written = typeof value === "number" && choices.length > 0 ? choices[value] : value;
    if (part === undefined) json[group] = written;
    else json[group] = { ...(json[group] as object | undefined), [part]: written };
  }
  return json;
}

/** The inverse of jsonOf(). Throws a sentence where the text is something else. */
export function valuesFromJson(text: string, fields: readonly SceneField[]): Values {
  const wrong = (what: string) => new Error(`This is no preset: ${what}.`);
  let json: unknown;
  try {
    json = JSON.parse(text);
  } catch {
    throw wrong("the file is not JSON");
  }
  if (typeof json !== "object" || json === null || Array.isArray(json)) throw wrong("it has no fields");
  // An answer of /api/scene has its revision next to the scene.
  const { scene = json } = json as { scene?: unknown };
  if (typeof scene !== "object" || scene === null) throw wrong("it has no fields");
  const flat = Object.entries(scene).flatMap(([group, value]) =>
    typeof value === "object" && value !== null
      ? Object.entries(value).map(([part, inner]) => [`${group}.${part}`, inner] as const)
      : [[group, value] as const],
  );
  return new Map(
    flat.map(([name, value]) => {
      const field = fields.find((each) => each.name === name);
      if (!field) throw wrong(`there is no field ${name}`);
      const choice = field.choices.indexOf(String(value));
      const read: Value | undefined = field.choices.length > 0 ? (choice < 0 ? undefined : choice) : (value as Value);
      if (typeof read !== (field.isText ? "string" : "number"))
        throw wrong(`${name} cannot be ${JSON.stringify(value)}`);
      return [name, read as Value];
    }),
  );
}

/** At most 40 bytes, as the server takes names. */
function shortened(name: string): string {
  let short = name.trim();
  while (new TextEncoder().encode(short).length > 40) short = short.slice(0, -1).trim();
  return short;
}

export interface OwnPresetEvents {
  fields(): readonly SceneField[];
  /** Values of the surface that was found. */
  found(): Values;
  ask(wish: PresetRequest["wish"], withCuts: boolean): void;
  failed(sentence: string): void;
}

export class OwnPresets {
  private readonly form: HTMLFormElement;
  private readonly name: HTMLInputElement;
  private readonly file: HTMLInputElement;
  private readonly withCuts: HTMLInputElement;
  private readonly names: HTMLDataListElement;
  private saved: readonly Look[] = [];

  constructor(
    private readonly root: HTMLDetailsElement,
    private readonly editor: Pick<SettingsEditor, "get">,
    private readonly events: OwnPresetEvents,
  ) {
    this.form = root.querySelector("form")!;
    this.name = root.querySelector<HTMLInputElement>("[type=text]")!;
    this.file = root.querySelector<HTMLInputElement>("[type=file]")!;
    this.withCuts = root.querySelector<HTMLInputElement>("[type=checkbox]")!;
    this.names = root.querySelector("datalist")!;
    this.form.onsubmit = (event) => {
      event.preventDefault();
      this.save(this.name.value.trim());
    };
    this.button("remove").onclick = () => this.named((name) => this.events.ask({ case: "remove", value: name }, false));
    this.button("export").onclick = () => this.exportFile();
    this.button("import").onclick = () => this.file.click();
    this.file.onchange = () => void this.importFile();
  }

  /** Whether this display's role may save. */
  allow(may: boolean): void {
    this.root.hidden = !may;
  }

  tell(list: PresetList): readonly Look[] {
    this.saved = list.saved.flatMap(({ preset }) => (preset ? [preset] : []));
    this.names.replaceChildren(...this.saved.map(({ name }) => element("option", { value: name })));
    return this.saved;
  }

  private button(wish: string): HTMLButtonElement {
    return this.form.querySelector<HTMLButtonElement>(`[data-preset-wish="${wish}"]`)!;
  }

  /** Without a scene: what is shown now. */
  private save(name: string, scene?: Scene): void {
    const look = create(LookSchema, { name, ...(scene && { scene }) });
    const shapes = scene ? scene.cuts?.shapes : this.editor.get("cuts.shapes");
    this.events.ask({ case: "save", value: look }, this.withCuts.checked && Boolean(shapes));
    this.withCuts.checked = false; // of this preset alone
  }

  private named(use: (name: string) => void): void {
    if (this.form.reportValidity()) use(this.name.value.trim());
  }

  /** The preset of this name, or what is shown now. */
  private exportFile(): void {
    const name = this.name.value.trim();
    const known = this.saved.find((preset) => preset.name === name);
    const withCuts = known ? known.scene?.cuts !== undefined : this.withCuts.checked;
    const isLeft = (group: string) => kLeftAlone.includes(group) && !(group === "cuts" && withCuts);
    const fields = this.events.fields().filter(({ name: each }) => !isLeft(each.split(".")[0]!));
    const shown = new Map(
      fields.flatMap(({ name: each }) => {
        const value = this.editor.get(each);
        return value === undefined ? [] : [[each, value] as const];
      }),
    );
    const json = jsonOf(known?.scene ? valuesOf(known.scene) : shown, fields);
    const blob = new Blob([`${JSON.stringify(json, undefined, 1)}\n`], { type: "application/json" });
    saveFile(blob, `${(name || "fanlight-preset").replace(/[^\p{L}\p{N} _-]/gu, "_")}.json`);
  }

  /** Saves the file under the name given, or the file's. */
  private async importFile(): Promise<void> {
    const file = this.file.files?.[0];
    if (!file) return;
    try {
      if (file.size > kMostFileBytes) throw new Error("This is no preset: the file is too large.");
      const values = valuesFromJson(await file.text(), this.events.fields());
      this.name.value ||= shortened(file.name.replace(/\.json$/i, ""));
      this.save(this.name.value.trim(), sceneOf(values));
    } catch (error) {
      this.events.failed((error as Error).message);
    }
    this.file.value = ""; // the same file may be chosen again
  }
}
