// SPDX-License-Identifier: Apache-2.0
// Texts of the status line about lost frames and the mismatch of forward and backward sweeps.
import type { Picture, Statistics, SweepWarning } from "../generated/fanlight_pb.js";

type Frames = Pick<Picture, "framesMissing" | "firstFrameSequence" | "lastFrameSequence">;

/** Of a volume's frames: one lost frame between many is not seen. */
const kWorthSaying = 0.1;

/** "4 of 20 frames interpolated"; empty for few. The statistics count all. */
export function interpolatedText({ framesMissing, firstFrameSequence, lastFrameSequence }: Frames): string {
  const frames = Number(lastFrameSequence - firstFrameSequence) + 1;
  return framesMissing === 0 || framesMissing < kWorthSaying * frames
    ? ""
    : `${framesMissing} of ${frames} frames interpolated`;
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
