// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import type { Mm } from "../src/measuring/figures";
import { planeThrough } from "../src/plane_through";
import { pixelIn, shownPlanes, type SliceCamera } from "../src/shown_planes";

const size = { width: 512, height: 512 };

/** The pixels of the points in the plane that the picture then shows. */
function shown(first: Mm, second: Mm, across: Mm, points: readonly Mm[]) {
  const { target, ...turn } = planeThrough(first, second, across)!;
  const [x, y, z] = target;
  const camera: SliceCamera = {
    ...turn,
    target: { x, y, z },
    fieldMm: 128, // 4 pixels a millimetre
    distanceMm: 80,
    sliceDepthMm: 80,
    perspective: false,
    openingDeg: 30,
    planes: { yawDeg: 0, pitchDeg: 0, rollDeg: 0 },
    plane: 0,
    stepMm: 5,
  };
  const [plane] = shownPlanes("slice", size, camera);
  return points.map(([px, py, pz]) => pixelIn({ x: px, y: py, z: pz }, plane!));
}

test("the plane holds both points, from left to right, and the direction across", () => {
  for (const [first, second, across] of [
    [
      [0, 60, 0],
      [20, 60, 0],
      [0, 1, 0],
    ],
    [
      [20, 60, 3],
      [0, 75, 3],
      [0, 0, 1],
    ],
    [
      [-5, 50, 10],
      [8, 90, -12],
      [1, 0, 0],
    ],
    [
      [3, 40, 1],
      [3, 70, 1],
      [0, 0, 1],
    ],
    [
      [1, 70, -9],
      [4, 66, 20],
      [0.2, 0.8, -0.5],
    ],
  ] as [Mm, Mm, Mm][]) {
    const beyond: Mm = [second[0] + 9 * across[0], second[1] + 9 * across[1], second[2] + 9 * across[2]];
    const [a, b, c] = shown(first, second, across, [first, second, beyond]);
    for (const { asideMm } of [a!, b!, c!]) assert.ok(asideMm < 0.05, `${asideMm} mm beside the plane`);
    assert.ok(a!.pixel.x <= b!.pixel.x + 0.1);
    const lengthMm = Math.hypot(second[0] - first[0], second[1] - first[1], second[2] - first[2]);
    const pixels = Math.hypot(b!.pixel.x - a!.pixel.x, b!.pixel.y - a!.pixel.y);
    assert.ok(Math.abs(pixels - 4 * lengthMm) < 0.2, `${pixels} pixels for ${lengthMm} mm`);
  }
});

test("depth points downwards where the plane shows it", () => {
  const [shallow, deep] = shown(
    [-10, 60, 5],
    [10, 62, 5],
    [0, 0.3, 1],
    [
      [0, 61, 5],
      [0, 64, 15],
    ],
  );
  assert.ok(deep!.pixel.y > shallow!.pixel.y);
});

test("points in one line with the direction make no plane", () => {
  assert.equal(planeThrough([0, 60, 0], [0, 60, 9], [0, 0, 1]), undefined);
  assert.equal(planeThrough([0, 60, 0], [0, 60, 0], [0, 0, 1]), undefined);
});
