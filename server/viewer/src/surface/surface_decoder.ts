// SPDX-License-Identifier: Apache-2.0
// Unpacks a surface as the server sends it (proto/DISPLAY_PROTOCOL.md, surfaces).
import type { Surface } from "../../generated/fanlight_pb.js";

/** The filtered depth map of a picture. Maps: height x width, top row first. */
export interface DepthMap {
  /** Pictures of which only the light differs have the same. */
  id: bigint;
  width: number;
  height: number;
  /** In steps of unitMm; kNoSurface: none. */
  depths: Uint16Array;
  unitMm: number;
  /** 0 where no ray met a surface, else how certain it is, 1 to 255. */
  certainties: Uint8Array;
  /** Smallest depth, mm; Infinity without a surface. */
  nearestMm: number;
}

export const kNoSurface = 65535;
const kLarge = 255; // announces two bytes among the large residuals
const kCalm = 6;
const kMostActivity = 40;
const kSentCertainties = 15;
const kSomeFilled = 128;

/** Rejects where the message is damaged. */
export async function unpackSurface(surface: Surface): Promise<DepthMap> {
  const parts = [surface.runs, surface.residuals, surface.largeResiduals, surface.certainties];
  const [runs, residuals, large, sent] = await Promise.all(parts.map(inflated));
  const map: DepthMap = {
    id: surface.surfaceId,
    width: surface.width,
    height: surface.height,
    depths: new Uint16Array(surface.width * surface.height).fill(kNoSurface),
    unitMm: surface.depthUnitMm,
    certainties: new Uint8Array(surface.width * surface.height),
    nearestMm: Infinity,
  };
  placeDepths(map, runs!, residuals!, large!, surface.calmPixels);
  placeCertainties(map, sent!);
  return map;
}

async function inflated(bytes: Uint8Array): Promise<Uint8Array> {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Lengths of runs of pixels, by turns without and with a surface. */
class Runs {
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {}

  next(): number {
    let length = 0;
    for (let shift = 0; this.at < this.bytes.length; shift += 7) {
      const byte = this.bytes[this.at++]!;
      length |= (byte & 127) << shift;
      if (byte < 128) return length;
    }
    throw new Error("A run of the surface is missing.");
  }
}

function placeDepths(
  map: DepthMap,
  runBytes: Uint8Array,
  residuals: Uint8Array,
  large: Uint8Array,
  calmPixels: number,
): void {
  const { width, height, depths } = map;
  const runs = new Runs(runBytes);
  // A row and the row above it, with a place before the first column and one behind the last. Where there is no
  // surface the depth above it is repeated.
  let [row, above] = [new Uint16Array(width + 2), new Uint16Array(width + 2)];
  let [activity, activityAbove] = [new Uint8Array(width + 2), new Uint8Array(width + 2)];
  let [calm, rough, largeAt] = [0, calmPixels, 0];
  let left = runs.next();
  let inSurface = false;
  let nearest = kNoSurface;
  for (let y = 0; y < height; ++y) {
    row[0] = above[0] = above[1]!;
    for (let x = 1; x <= width; ++x) {
      while (left === 0) {
        left = runs.next();
        inSurface = !inSurface;
      }
      --left;
      if (!inSurface) {
        row[x] = above[x]!;
        activity[x] = 0;
        continue;
      }
      const around = activity[x - 1]! + activityAbove[x - 1]! + activityAbove[x]! + activityAbove[x + 1]!;
      let folded = residuals[around <= kCalm ? calm++ : rough++]!;
      if (folded === kLarge) {
        folded = large[largeAt]! | (large[largeAt + 1]! << 8);
        largeAt += 2;
      }
      const difference = folded & 1 ? -((folded + 1) >> 1) : folded >> 1;
      row[x] = row[x - 1]! + above[x]! - above[x - 1]! + difference; // modulo 2^16
      const depth = row[x]!;
      activity[x] = folded > kMostActivity ? kMostActivity : folded;
      depths[y * width + x - 1] = depth;
      if (depth < nearest) nearest = depth;
    }
    [row, above] = [above, row];
    [activity, activityAbove] = [activityAbove, activity];
  }
  if (calm !== calmPixels || rough !== residuals.length || largeAt !== large.length)
    throw new Error("The surface has other numbers of pixels than it says.");
  if (nearest !== kNoSurface) map.nearestMm = nearest * map.unitMm;
}

/** A value for each block of 2 x 2 pixels that has a surface. */
function placeCertainties({ width, height, depths, certainties }: DepthMap, sent: Uint8Array): void {
  let next = 0;
  for (let y = 0; y < height; y += 2) {
    for (let x = 0; x < width; x += 2) {
      const first = y * width + x;
      const pixels = [first, x + 1 < width ? first + 1 : -1, first + width, x + 1 < width ? first + width + 1 : -1];
      if (y + 1 === height) pixels.length = 2;
      if (!pixels.some((pixel) => pixel >= 0 && depths[pixel] !== kNoSurface)) continue;
      const filled = sent[next]! & kSomeFilled ? sent[next++]! : 0;
      const step = sent[next++] ?? 0;
      const certainty = step === 0 ? 0 : 1 + Math.round((254 * (step - 1)) / kSentCertainties);
      for (const [place, pixel] of pixels.entries())
        if (pixel >= 0 && depths[pixel] !== kNoSurface) certainties[pixel] = filled & (1 << place) ? 0 : certainty;
    }
  }
  if (next !== sent.length) throw new Error("The surface has another number of certainties than it has blocks.");
}

/** The map of every `level`-th pixel of every `level`-th row. */
export function coarser(map: DepthMap, level: number): DepthMap {
  const [width, height] = [Math.ceil(map.width / level), Math.ceil(map.height / level)];
  const made = {
    ...map,
    width,
    height,
    depths: new Uint16Array(width * height),
    certainties: new Uint8Array(width * height),
  };
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const from = y * level * map.width + x * level;
      made.depths[y * width + x] = map.depths[from]!;
      made.certainties[y * width + x] = map.certainties[from]!;
    }
  }
  return made;
}
