// SPDX-License-Identifier: Apache-2.0
// The measured values that fields in force ask for by being 0.
import type { EchoLevels } from "../generated/fanlight_pb.js";
import { kSurfaceModes } from "./field_effects";
import { numberText } from "./field_text";
import { kSomeSurface } from "./uncertain_mark";
import type { SettingsEditor } from "./settings_editor";

/** Fields that can ask the data. */
export const kMeasuredFields = ["detector.threshold", "detector.least_tissue", "speckle.noise", "speckle.levels"];

export class MeasuredValues {
  private levels: EchoLevels | undefined;
  private surfaceShare = 0;

  constructor(private readonly editor: Pick<SettingsEditor, "number" | "choice">) {}

  /** Takes the levels of a picture, and the share of it that has a surface; whether a text of this object has changed. */
  take(levels: EchoLevels | undefined, surfaceShare = 0): boolean {
    const before = this.texts();
    this.levels = levels;
    this.surfaceShare = surfaceShare;
    return before !== this.texts();
  }

  /** Whether a surface is wanted, and the picture shows none because there is speckle alone. */
  hasNoSurface(): boolean {
    const wantsSurface = kSurfaceModes.includes(this.editor.choice("mode"));
    return Boolean(this.levels?.flat) && wantsSurface && this.surfaceShare < kSomeSurface;
  }

  /** The value in force of a field that is 0, "from the data"; undefined for other fields, and where none is known. */
  valueOf(name: string): number | undefined {
    if (!this.levels || this.levels.flat || this.editor.number(name) !== 0) return undefined;
    const { leastTissue, linear, noise, tissue, threshold } = this.levels;
    if (name === "detector.threshold") return Math.round(10 * threshold) / 10;
    if (name === "detector.least_tissue") return Math.round(10 * leastTissue) / 10;
    const measured = this.editor.number("speckle.noise") === 0 && this.editor.number("speckle.levels") === 0;
    if (!measured || this.editor.choice("speckle.filter") !== "guided") return undefined;
    if (name === "speckle.noise" && linear) return Math.round((100 * noise) / tissue) / 100;
    if (name === "speckle.levels" && !linear) return Math.round(10 * noise) / 10;
    return undefined;
  }

  /** "Now 22, from the data: fluid 7, tissue 142."; empty where valueOf() has none. */
  text(name: string): string {
    const value = this.valueOf(name);
    if (value === undefined || !this.levels) return "";
    const { fluid, tissue } = this.levels;
    const levels = name.startsWith("detector.") ? `: fluid ${numberText(fluid)}, tissue ${numberText(tissue)}` : "";
    return `Now ${numberText(value)}, from the data${levels}.`;
  }

  private texts(): string {
    return kMeasuredFields.map((name) => this.text(name)).join("\n");
  }
}
