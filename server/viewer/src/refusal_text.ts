// SPDX-License-Identifier: Apache-2.0
// Refusals of the server in the words of the page: "Threshold" for detector.threshold.
import type { SceneField } from "../generated/fanlight_pb.js";
import { sections } from "./settings_layout";
import { labelOf } from "./field_text";

/** Each field's title as the settings show it, with its group where the title alone could be another's. */
export function titlesOf(fields: readonly SceneField[]): Map<string, string> {
  return new Map(
    sections(fields).flatMap(({ group, title, settings }) =>
      settings.flatMap((setting) =>
        (setting.kind === "field" ? [setting.field] : setting.parts).map(
          ({ name }) => [name, group === "" ? labelOf(name) : `${title}: ${labelOf(name)}`] as const,
        ),
      ),
    ),
  );
}

export function inPlainWords(sentence: string, titles: ReadonlyMap<string, string>): string {
  const plain = sentence.replace(/\b[a-z0-9]+\.[a-z0-9_]+\b/g, (name) => titles.get(name) ?? name);
  return plain.charAt(0).toUpperCase() + plain.slice(1);
}
