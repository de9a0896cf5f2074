// The two inputs of a number: a slider to aim with, and a box that takes the field's whole range.
import type { SceneField } from "../generated/fanlight_pb.js";
import { element, typedBox } from "./element";
import { numberText, sliderRange } from "./field_text";
import { allowed } from "./scene";

/** Of lengths it covers what can be aimed, twice the picture's height; it has the field's name as id. */
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
 * `show` puts the value into the box, unless it is being typed into. What is out of a field's range is the server's to
 * refuse; a field with a step takes the nearest allowed value, since one between its steps could not even be sent.
 */
export function numberBox(
  field: SceneField,
  title: string,
  value: () => number,
  take: (typed: number) => void,
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
  return { input, show: typedBox(input, () => numberText(value()), takeNumber) };
}
