// SPDX-License-Identifier: Apache-2.0
// The mark over a picture, much of whose surface differs from speckle by little.
import type { Picture } from "../generated/fanlight_pb.js";

/** Rims are a guess in every picture. */
const kWorthSaying = 0.1;

/** What the mark says; empty: nothing. `threshold`: of the scene, 0 from the data. */
export function guessText(picture: Pick<Picture, "guessedShare" | "levels">, threshold: number): string {
  const percent = Math.round(100 * picture.guessedShare);
  if (picture.guessedShare >= kWorthSaying) return `${percent} % of the surface is a guess: dimmed`;
  if (picture.levels?.flat && threshold > 0) return "Speckle only, but for what stands out of it";
  return "";
}

export class GuessMark {
  constructor(private readonly mark: HTMLElement) {}

  show(picture: Pick<Picture, "guessedShare" | "levels">, threshold: number): void {
    const text = guessText(picture, threshold);
    this.mark.textContent = text;
    this.mark.hidden = text === "";
  }
}
