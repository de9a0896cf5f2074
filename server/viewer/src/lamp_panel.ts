// SPDX-License-Identifier: Apache-2.0
// The three lights in reach: which of them moves, whether it is on, its colour and strength, and buttons for its place.
import { hexOf, partsOf } from "./colour";
import { element, find } from "./element";
import { kLamps, kLampTitles, type Lamp } from "./lamps";
import type { LightHandles } from "./light_handles";
import type { SettingsEditor } from "./settings_editor";
import { tidy } from "./view_geometry";

const kRimBehind = 0.5;
const kUsualRim = 0.12; // of the look "skin"
const kColours = ["red", "green", "blue"];
const kPercent = 100;

export class LampPanel {
  private readonly summary = find("#lamps-on", HTMLElement);
  private readonly choices = find("#lamp-choice", HTMLElement);
  private readonly on = find("#lamp-on", HTMLInputElement);
  private readonly colour = find("#lamp-colour", HTMLInputElement);
  private readonly strength = find("#lamp-strength", HTMLInputElement);
  private readonly output = find("#lamp-strength-shown", HTMLElement);
  private rimBefore = kUsualRim; // of a key light that was not behind
  /** The light that the controls show, on or off; the handles move it if it is on. */
  private lamp: Lamp = "light";

  constructor(
    private readonly editor: Pick<SettingsEditor, "set" | "number" | "choice">,
    private readonly handles: LightHandles,
    places: HTMLElement,
  ) {
    for (const button of places.querySelectorAll("button")) button.onclick = () => this.moveTo(button.dataset.light);
    this.choices.append(...kLamps.map((lamp) => this.choice(lamp)));
    handles.onChosen = (lamp) => {
      this.lamp = lamp;
      this.refresh();
    };
    this.on.onchange = () => {
      this.editor.set([[`${this.lamp}.on`, Number(this.on.checked)]]);
      handles.choose(this.lamp);
    };
    this.colour.oninput = () => {
      const parts = partsOf(this.colour.value);
      this.editor.set(kColours.map((name, index) => [`${this.lamp}.${name}`, parts[index]!]));
    };
    this.strength.oninput = () =>
      this.editor.set([[`${this.lamp}.strength`, tidy(Number(this.strength.value) / kPercent)]]);
  }

  /** After a change of the scene. */
  refresh(): void {
    const isOn = (lamp: Lamp) => this.editor.choice(`${lamp}.on`) === "on";
    const on = kLamps.filter(isOn).map((lamp) => kLampTitles[lamp].toLowerCase());
    this.summary.textContent = on.length > 0 ? on.join(", ") : "all off";
    for (const input of this.choices.querySelectorAll("input")) input.checked = input.value === this.lamp;
    this.on.checked = isOn(this.lamp);
    this.colour.value = hexOf(kColours.map((name) => this.editor.number(`${this.lamp}.${name}`)));
    const percent = Math.round(kPercent * this.editor.number(`${this.lamp}.strength`));
    this.strength.value = String(percent);
    this.output.textContent = `${percent} %`;
  }

  private choice(lamp: Lamp): HTMLElement {
    const input = element("input", { type: "radio", name: "lamp", value: lamp });
    input.onchange = () => this.handles.choose(lamp);
    return element("label", {}, input, element("span", { textContent: kLampTitles[lamp] }));
  }

  /**
   * "RIGHT UP DEPTH": where the chosen light is from the target, in heights of what the picture shows. A key light from
   * behind needs bright edges, or the picture would be nearly black.
   */
  private moveTo(place = ""): void {
    const [right = 0, up = 0, depth = 0] = place.split(" ").map(Number);
    const { lamp } = this;
    const fieldMm = this.editor.number("camera.field_mm");
    const rim = this.editor.number("light.rim");
    if (rim !== kRimBehind) this.rimBefore = rim;
    this.editor.set([
      [`${lamp}.right_mm`, tidy(right * fieldMm)],
      [`${lamp}.up_mm`, tidy(up * fieldMm)],
      [`${lamp}.depth_mm`, tidy(this.editor.number("camera.distance_mm") + depth * fieldMm)],
      [`${lamp}.on`, 1],
      ...(lamp === "light" ? [["light.rim", depth > 0 ? kRimBehind : this.rimBefore] as const] : []),
    ]);
  }
}
