// SPDX-License-Identifier: Apache-2.0
// The mark over a picture, much of whose surface differs from speckle by little.
import type { Picture } from "../generated/fanlight_pb.js";

type Shares = Pick<Picture, "uncertainShare" | "surfaceShare" | "levels"> & Partial<Pick<Picture, "view">>;

/** Rims are uncertain in every picture. */
const kWorthSaying = 0.1;
/** Of the picture: less may be a stray edge in speckle. */
export const kSomeSurface = 0.005;

/** Cosine between the middle beam and what looks at the picture: beyond it, beams dim the surface (shaders/cast.comp). */
const kFromBehind = -0.6;

/** What the mark says; empty: nothing. */
export function uncertainText({ uncertainShare, surfaceShare, levels, view }: Shares): string {
  const texts: string[] = [];
  if (levels?.flat && surfaceShare >= kSomeSurface) texts.push("Mostly speckle: only what stands out from it is shown");
  const percent = Math.round(100 * uncertainShare);
  const isFromBehind = (view?.matrix[6] ?? 1) < kFromBehind; // forward, along the depth of the probe
  if (uncertainShare >= kWorthSaying && isFromBehind)
    texts.push(`Seen from behind, where few beams or none came: ${percent} % of the surface is dimmed`);
  else if (uncertainShare >= kWorthSaying) texts.push(`${percent} % of the surface is uncertain (dimmed)`);
  return texts.join(". ");
}

export class UncertainMark {
  constructor(private readonly mark: HTMLElement) {}

  show(picture: Shares): void {
    const text = uncertainText(picture);
    this.mark.textContent = text;
    this.mark.hidden = text === "";
  }
}
