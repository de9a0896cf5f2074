// SPDX-License-Identifier: Apache-2.0
// The six sliders in reach: threshold, smooth, steady, brightness, shadow, glass. Each shows a percentage, grey levels or
// a number of volumes, which is converted to a field of the scene.
import type { EchoLevels } from "../generated/fanlight_pb.js";
import { element } from "./element";
import type { FieldEffects } from "./field_effects";
import { tidy } from "./view_geometry";
import type { SettingsEditor } from "./settings_editor";

const kMostSmoothMm = 12;
const kMiddleExposure = 2.1; // of the look "skin"
const kBrightest = 3.8; // factor from the middle of the slider to its end: the field ends at 8

interface Quick {
  field: string;
  title: string;
  help: string;
  unit: string;
  /** Of the slider; 0 to 100 where there is none. */
  range?: readonly [number, number];
  toField(shown: number): number;
  toShown(value: number): number;
}

export const kQuick: readonly Quick[] = [
  {
    field: "detector.threshold",
    title: "Threshold",
    help: "How bright an echo must be to count as the surface",
    unit: "",
    toField: (shown) => shown,
    toShown: (value) => value,
  },
  {
    field: "filter.size_mm",
    title: "Smooth",
    help: "How much of the surface's roughness is removed",
    unit: "%",
    toField: (percent) => tidy(Math.max(0.1, (percent / 100) * kMostSmoothMm)),
    toShown: (mm) => (100 * mm) / kMostSmoothMm,
  },
  {
    field: "filter.steady",
    title: "Steady",
    help: "Averages the surface over this many volumes, aligned, where nothing moves by itself: hold the probe still",
    unit: "volumes",
    range: [1, 8],
    toField: (volumes) => tidy(1 - 1 / volumes),
    toShown: (share) => 1 / (1 - share),
  },
  {
    field: "finish.exposure",
    title: "Brightness",
    help: "All light on the surface",
    unit: "%",
    toField: (percent) => tidy(kMiddleExposure * kBrightest ** ((percent - 50) / 50)),
    toShown: (exposure) => 50 + (50 * Math.log(exposure / kMiddleExposure)) / Math.log(kBrightest),
  },
  {
    field: "shadow.coefficient",
    title: "Shadow",
    help: "How dark a shadow is",
    unit: "%",
    toField: (percent) => tidy(1 - percent / 100),
    toShown: (coefficient) => 100 * (1 - coefficient),
  },
  {
    field: "glass.amount",
    title: "Glass",
    help: "How far the surface is seen through: at 0 % it is opaque, at 100 % only outlines are seen",
    unit: "%",
    toField: (percent) => tidy(percent / 100),
    toShown: (amount) => 100 * amount,
  },
];

function tenths(value: number): number {
  return Math.round(10 * value) / 10;
}

/** The grey levels that the threshold's slider covers: from the fluid to well inside the tissue. */
export function thresholdRange(levels: EchoLevels | undefined, value: number): { low: number; high: number } {
  const low = levels ? Math.max(1, Math.floor(levels.fluid)) : 1;
  const high = levels ? Math.ceil(levels.fluid + 1.2 * (levels.tissue - levels.fluid)) : 255;
  return { low: Math.min(low, Math.ceil(value)), high: Math.min(255, Math.max(high, low + 10, Math.ceil(value))) };
}

interface Row {
  quick: Quick;
  root: HTMLElement;
  slider: HTMLInputElement;
  output: HTMLOutputElement;
  auto: HTMLButtonElement | undefined;
}

export class QuickSettings {
  private readonly rows: Row[];
  private levels: EchoLevels | undefined;
  private changing: Row | undefined; // whose change the picture lacks

  constructor(
    form: HTMLFormElement,
    private readonly editor: SettingsEditor,
    private readonly effects: FieldEffects,
  ) {
    form.onsubmit = (event) => event.preventDefault();
    this.rows = kQuick.map((quick) => this.row(quick));
    form.replaceChildren(...this.rows.map(({ root }) => root));
  }

  /** The levels of the picture shown; whether they have changed by a grey level or more. */
  take(levels: EchoLevels | undefined): void {
    const rounded = (of: EchoLevels | undefined) =>
      of && [Math.round(of.fluid), Math.round(of.tissue), tenths(of.threshold)].join();
    if (rounded(levels) === rounded(this.levels)) return;
    this.levels = levels;
    this.refresh();
  }

  /** Whether the picture lacks a change of this display. */
  setBusy(busy: boolean): void {
    if (!busy && this.changing) {
      this.changing = undefined;
      this.refresh();
    }
  }

  refresh(): void {
    for (const row of this.rows) this.show(row);
  }

  private row(quick: Quick): Row {
    const id = `quick-${quick.field}`;
    const [min, max] = (quick.range ?? [0, 100]).map(String) as [string, string];
    const slider = element("input", { type: "range", id, min, max, step: "1", title: quick.help });
    slider.dataset.quick = quick.field;
    const output = element("output", {});
    output.setAttribute("for", id);
    const auto =
      quick.field === "detector.threshold"
        ? element("button", { type: "button", textContent: "Auto", title: "Set it from the echoes of each volume" })
        : undefined;
    const label = element("label", { htmlFor: id, textContent: quick.title });
    const root = element("div", { className: "quick" }, label, output, ...(auto ? [auto] : []), slider);
    const row = { quick, root, slider, output, auto };
    slider.oninput = () => this.set(row, quick.toField(slider.valueAsNumber));
    if (auto) auto.onclick = () => this.set(row, 0);
    return row;
  }

  private set(row: Row, value: number): void {
    this.changing = row;
    this.editor.set([[row.quick.field, value]]);
  }

  private show(row: Row): void {
    const { quick, root, slider, output, auto } = row;
    const value = this.editor.number(quick.field);
    const isAuto = auto !== undefined && value === 0;
    const inForce = isAuto ? (this.levels?.threshold ?? 0) : value;
    if (auto) {
      const { low, high } = thresholdRange(this.levels, inForce);
      [slider.min, slider.max] = [String(low), String(high)];
      auto.ariaPressed = String(isAuto);
    }
    // What is measured is shown as in the advanced settings.
    const shown = isAuto ? tenths(inForce) : Math.round(quick.toShown(inForce));
    slider.value = String(shown);
    const unit = shown === 1 ? quick.unit.replace(/s$/, "") : quick.unit; // 1 volume
    const isOff = quick.range !== undefined && value === 0;
    const text = Number.isNaN(value)
      ? ""
      : isOff
        ? "off"
        : `${quick.range ? "up to " : ""}${shown}${unit && ` ${unit}`}`;
    const busy = this.changing === row;
    output.textContent = busy ? `${text}, rendering …` : text;
    output.classList.toggle("busy", busy);
    slider.ariaValueText = isAuto ? `${shown} grey levels, automatic` : text || String(shown);
    const missing = this.effects.missing(quick.field) ?? this.effects.missing(quick.field.split(".")[0]!);
    root.classList.toggle("idle", missing !== undefined);
    root.title = missing ?? quick.help;
  }
}
