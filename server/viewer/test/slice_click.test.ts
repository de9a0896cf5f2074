// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { slicePoint, type BodyPoint, type SliceCamera } from "../src/slice_click";

const size = { width: 800, height: 400 };
const camera: SliceCamera = {
  fieldMm: 200,
  distanceMm: 50,
  perspective: false,
  openingDeg: 90,
  target: { x: 1, y: 80, z: -5 },
  yawDeg: 0,
  pitchDeg: 0,
  rollDeg: 0,
  sliceDepthMm: 50,
};

function near(actual: BodyPoint | undefined, expected: BodyPoint): void {
  assert.ok(actual);
  for (const axis of ["x", "y", "z"] as const)
    assert.ok(Math.abs(actual[axis] - expected[axis]) < 0.02, `${axis}: ${actual[axis]}, not ${expected[axis]}`);
}

test("the middle of each pane of the slices is the target; the fourth pane is no slice", () => {
  for (const pixel of [
    { x: 200, y: 100 },
    { x: 600, y: 100 },
    { x: 200, y: 300 },
  ])
    near(slicePoint(pixel, "slices", size, camera), camera.target);
  assert.equal(slicePoint({ x: 600, y: 300 }, "slices", size, camera), undefined);
  assert.equal(slicePoint({ x: 200, y: 100 }, "surface", size, camera), undefined);
});

test("the panes show x and depth, z and depth, and x and z; a pixel is a millimetre here", () => {
  near(slicePoint({ x: 220, y: 130 }, "slices", size, camera), { x: 21, y: 110, z: -5 });
  near(slicePoint({ x: 620, y: 130 }, "slices", size, camera), { x: 1, y: 110, z: 15 });
  near(slicePoint({ x: 220, y: 330 }, "slices", size, camera), { x: 21, y: 80, z: -35 });
});

test("an oblique slice lies at its depth, at a right angle to the view", () => {
  const middle = { x: 400, y: 200 };
  near(slicePoint(middle, "slice", size, camera), camera.target);
  near(slicePoint(middle, "slice", size, { ...camera, sliceDepthMm: 60 }), { x: 1, y: 90, z: -5 });
  // To the right by 40 pixels of half a millimetre, upwards by 20.
  const aside = { x: 440, y: 180 };
  near(slicePoint(aside, "slice", size, camera), { x: 21, y: 80, z: 5 });
  // From the side: the right of the picture is deeper.
  near(slicePoint(aside, "slice", size, { ...camera, yawDeg: 90 }), { x: 1, y: 100, z: 5 });
  // From above: forward is -z, and up in the picture is deeper.
  near(slicePoint(aside, "slice", size, { ...camera, pitchDeg: 90 }), { x: 21, y: 90, z: -5 });
  near(slicePoint(aside, "slice", size, { ...camera, rollDeg: 90 }), { x: 11, y: 80, z: -25 });
});

test("in perspective a deeper slice shows more of the body", () => {
  // The eye stands 100 mm before the target, so at 50 mm behind it everything is 1.5 times as far aside.
  const deeper = { ...camera, perspective: true, sliceDepthMm: 100 };
  near(slicePoint({ x: 440, y: 180 }, "slice", size, deeper), { x: 31, y: 130, z: 10 });
});
