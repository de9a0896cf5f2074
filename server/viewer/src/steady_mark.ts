// SPDX-License-Identifier: Apache-2.0
// The mark over a picture whose surface is the mean of several volumes, or blended between two sweeps.
import type { Picture } from "../generated/fanlight_pb.js";

type Steadiness = Pick<Picture, "steadyShare" | "meanVolumes" | "seamFrames">;

/** Less of the surface may be a stray match; a little is always newly seen. */
const [kSome, kAll] = [0.1, 0.95];

/** What the mark says; empty: nothing. */
export function steadyText({ steadyShare, meanVolumes, seamFrames }: Steadiness): string {
  if (seamFrames > 0) return `Sweeps blended over ${seamFrames} ${seamFrames === 1 ? "frame" : "frames"}`;
  const volumes = Math.round(meanVolumes);
  if (volumes < 2 || steadyShare < kSome) return "";
  return `${steadyShare < kAll ? `${5 * Math.round(20 * steadyShare)} % of the surface` : "Surface"} steady over ${volumes} volumes`;
}

/** A number that stays until it is clearly another one: it must not flicker from volume to volume. */
class Held {
  private value = 0;
  constructor(private readonly most: number) {}
  of(value: number): number {
    if (Math.abs(value - this.value) > this.most) this.value = value;
    return this.value;
  }
}

export class SteadyMark {
  private readonly share = new Held(0.08);
  private readonly volumes = new Held(0.75);

  constructor(private readonly mark: HTMLElement) {}

  show(picture: Steadiness): void {
    const text = steadyText({
      steadyShare: this.share.of(picture.steadyShare),
      meanVolumes: this.volumes.of(picture.meanVolumes),
      seamFrames: picture.seamFrames,
    });
    if (this.mark.textContent !== text) this.mark.textContent = text;
    this.mark.hidden = text === "";
  }
}
