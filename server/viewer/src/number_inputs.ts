// SPDX-License-Identifier: Apache-2.0
// The two inputs of a number: a slider, and a box that accepts the whole range of the field.
import type { SceneField } from "../generated/fanlight_pb.js";
import { element, typedBox } from "./element";
import { numberText, sliderRange } from "./field_text";
import { allowed } from "./scene";

/** For lengths it covers twice the height of the picture at most (sliderRange). Its id is the name of the field. */
export function sliderOf(field: SceneField, pictureHeightMm: number): HTMLInputElement {
  const { low, high, step } = sliderRange(field, pictureHeightMm);
  const slider = element("input", {
    type: "range",
    id: field.name,
    min: String(low),
    max: String(high),
    step: String(step),
  });
  slider.dataset.field = field.name;
  return slider;
}

/**
 * `show` writes the value into the box, unless the user is typing. The server refuses values out of range. A field with
 * a step takes the nearest allowed value, because the schema cannot carry a value between two steps.
 */
export function numberBox(
  field: SceneField,
  title: string,
  value: () => number,
  take: (typed: number) => void,
  /** The value in force where the field leaves it to the data: the box then has "auto". */
  measured: () => number | undefined = () => undefined,
): { input: HTMLInputElement; show: () => void } {
  const input = element("input", {
    type: "number",
    step: field.step > 0 ? String(field.step) : "any",
    min: String(field.minimum),
    max: String(field.maximum),
  });
  input.dataset.number = field.name;
  input.setAttribute("aria-label", `${title}, ${field.unit || "number"}`);
  const takeNumber = () => {
    const typed = input.valueAsNumber;
    if (Number.isFinite(typed)) take(field.step > 0 ? allowed(field, typed) : typed);
  };
  const text = () => (measured() === undefined ? numberText(value()) : "");
  const showValue = typedBox(input, text, takeNumber);
  const show = () => {
    input.placeholder = measured() === undefined ? "" : "auto";
    showValue();
  };
  return { input, show };
}
