// SPDX-License-Identifier: Apache-2.0
// Texts of the status line about lost frames and the mismatch of forward and backward sweeps.
import type { Statistics, SweepWarning } from "../generated/fanlight_pb.js";

/** "2 frames interpolated"; empty for none. */
export function interpolatedText(framesMissing: number): string {
  if (framesMissing === 0) return "";
  return framesMissing === 1 ? "1 frame interpolated" : `${framesMissing} frames interpolated`;
}

/** "frames over 5 deg apart"; empty where they are not. */
export function sparseText(warnings: Pick<SweepWarning, "name">[]): string {
  return warnings.some(({ name }) => name === "sparse") ? "frames over 5 deg apart" : "";
}

/** "corrected 1.02 deg, left 0.03 deg (0.06 mm)"; empty if all three round to 0.00. */
export function mismatchText(
  statistics: Pick<Statistics, "mismatchDeg" | "mismatchLeftDeg" | "mismatchLeftMm">,
): string {
  const { mismatchDeg, mismatchLeftDeg, mismatchLeftMm } = statistics;
  const texts = [mismatchDeg, mismatchLeftDeg, mismatchLeftMm].map(hundredths);
  if (texts.every((text) => text === "0.00")) return "";
  return `corrected ${texts[0]} deg, left ${texts[1]} deg (${texts[2]} mm)`;
}

function hundredths(value: number): string {
  const text = value.toFixed(2);
  return text === "-0.00" ? "0.00" : text;
}
