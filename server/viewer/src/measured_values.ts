// SPDX-License-Identifier: Apache-2.0
// The values that the newest picture's frames gave for fields that ask for values from the data.
import type { EchoLevels } from "../generated/fanlight_pb.js";
import { numberText } from "./field_text";
import type { SettingsEditor } from "./settings_editor";

export class MeasuredValues {
  private levels: EchoLevels | undefined;

  constructor(private readonly editor: Pick<SettingsEditor, "number">) {}

  /** Takes the levels of a picture; whether a text of this object may have changed. */
  take(levels: EchoLevels | undefined): boolean {
    const before = JSON.stringify([this.text("detector.threshold"), this.text("speckle.levels")]);
    this.levels = levels;
    return before !== JSON.stringify([this.text("detector.threshold"), this.text("speckle.levels")]);
  }

  /** The value in force of a field that is 0, "from the data"; undefined for other fields, and where none is known. */
  valueOf(name: string): number | undefined {
    if (!this.levels || this.editor.number(name) !== 0) return undefined;
    switch (name) {
      case "detector.threshold":
        return rounded(this.levels.threshold);
      case "speckle.levels":
        return this.levels.linear || this.editor.number("speckle.noise") !== 0 ? undefined : rounded(this.levels.noise);
      default:
        return undefined;
    }
  }

  /** "Now 22, from the data: fluid 7, tissue 142."; empty where valueOf() has none. */
  text(name: string): string {
    const value = this.valueOf(name);
    if (value === undefined || !this.levels) return "";
    const { fluid, tissue } = this.levels;
    const levels = name === "detector.threshold" ? `: fluid ${numberText(fluid)}, tissue ${numberText(tissue)}` : "";
    return `Now ${numberText(value)}, from the data${levels}.`;
  }
}

function rounded(level: number): number {
  return Math.round(10 * level) / 10;
}
