// SPDX-License-Identifier: Apache-2.0
// Coarse depth maps of what is on show, to tell where two pictures of one view show the same surface.

/** Depths in mm, top row first; negative: no surface. */
export interface DepthGrid {
  width: number;
  height: number;
  depthsMm: Float32Array;
}

const kSide = 96;

/** A grid of at most kSide values on each side; `depthMm` of a pixel of a map of that size. */
export function depthGrid(
  size: { width: number; height: number },
  depthMm: (column: number, row: number) => number,
): DepthGrid {
  const [width, height] = [Math.min(kSide, size.width), Math.min(kSide, size.height)];
  const depthsMm = new Float32Array(width * height);
  const at = (index: number, few: number, many: number) => Math.floor(((index + 0.5) * many) / few);
  for (let row = 0; row < height; ++row)
    for (let column = 0; column < width; ++column)
      depthsMm[row * width + column] = depthMm(at(column, width, size.width), at(row, height, size.height));
  return { width, height, depthsMm };
}

/**
 * For each value of a grid, 255 where the other one has the same surface: depths that differ by at most `mostMm`, or no
 * surface in both; else 0. Empty where the sizes differ.
 */
export function agreement(one: DepthGrid, other: DepthGrid, mostMm: number): Uint8ClampedArray {
  if (one.width !== other.width || one.height !== other.height) return new Uint8ClampedArray();
  return Uint8ClampedArray.from(one.depthsMm, (depth, index) => {
    const seen = other.depthsMm[index]!;
    const agrees = depth < 0 || seen < 0 ? depth < 0 && seen < 0 : Math.abs(depth - seen) <= mostMm;
    return agrees ? 255 : 0;
  });
}
