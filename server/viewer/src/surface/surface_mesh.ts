// SPDX-License-Identifier: Apache-2.0
// A depth map as triangles.
import { kNoSurface, type DepthMap } from "./surface_decoder";

/** Triangles as the indices of three pixels each, row by row. Seen from the viewer they turn one way. */
export interface SurfaceMesh {
  /** First those of the surface, then those that bridge a step of it. */
  indices: Uint32Array;
  surfaceIndices: number;
}

/** `largestStepMm`: between neighbours of one surface. */
export function meshOf({ width, height, depths, unitMm }: DepthMap, largestStepMm: number): SurfaceMesh {
  const indices = new Uint32Array(6 * (width - 1) * (height - 1));
  const largest = largestStepMm / unitMm;
  let [front, back] = [0, indices.length]; // those of steps are written from the end
  const add = (a: number, b: number, c: number) => {
    const [first, second, third] = [depths[a]!, depths[b]!, depths[c]!];
    const most = Math.max(first, second, third);
    if (most === kNoSurface) return;
    const step = most - Math.min(first, second, third) > largest;
    const at = step ? (back -= 3) : (front += 3) - 3;
    indices[at] = a;
    indices[at + 1] = b;
    indices[at + 2] = c;
  };
  for (let y = 0; y + 1 < height; ++y) {
    for (let pixel = y * width; pixel + 1 < (y + 1) * width; ++pixel) {
      const below = pixel + width;
      add(pixel, pixel + 1, below);
      add(below + 1, below, pixel + 1);
    }
  }
  indices.copyWithin(front, back);
  return { indices: indices.subarray(0, front + indices.length - back), surfaceIndices: front };
}
