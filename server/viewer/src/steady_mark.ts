// SPDX-License-Identifier: Apache-2.0
// The mark over a picture whose surface is the mean of several volumes.
import type { Picture } from "../generated/fanlight_pb.js";

/** What the mark says; empty: nothing. */
export function steadyText({ meanVolumes }: Pick<Picture, "meanVolumes">): string {
  const volumes = Math.round(meanVolumes);
  return volumes > 1 ? `Steady over ${volumes} volumes` : "";
}

export class SteadyMark {
  constructor(private readonly mark: HTMLElement) {}

  show(picture: Pick<Picture, "meanVolumes">): void {
    const text = steadyText(picture);
    if (this.mark.textContent !== text) this.mark.textContent = text;
    this.mark.hidden = text === "";
  }
}
