// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { orbited, pixelOf, scaleAt, surfacePart, viewPoint } from "../src/view_geometry";

const picture = { width: 800, height: 400 };
const whole = { left: 0, top: 0, width: 800, height: 400 };

test("the surface has the whole picture, a half, a quarter, or no place", () => {
  for (const mode of ["surface", "volume", "maximum", "depth"]) assert.deepEqual(surfacePart(mode, picture), whole);
  assert.deepEqual(surfacePart("surface-and-volume", picture), {
    left: 0,
    top: 0,
    width: 400,
    height: 400,
    fieldPixels: 400,
  });
  assert.deepEqual(surfacePart("slices", picture), { left: 400, top: 200, width: 400, height: 200 });
  assert.deepEqual(surfacePart("slices", { width: 5, height: 7 }), { left: 2, top: 3, width: 3, height: 4 });
  assert.equal(surfacePart("slice", picture), undefined);
});

test("the centre is the origin, right and up are positive, the height is the field", () => {
  assert.deepEqual(viewPoint({ x: 400, y: 200 }, whole, 160), { rightMm: 0, upMm: 0 });
  assert.deepEqual(viewPoint({ x: 800, y: 0 }, whole, 160), { rightMm: 160, upMm: 80 });
  assert.deepEqual(viewPoint({ x: 0, y: 400 }, whole, 160), { rightMm: -160, upMm: -80 });
});

test("a part of the picture has its own centre, and its height is the field", () => {
  const quarter = surfacePart("slices", picture)!;
  assert.deepEqual(viewPoint({ x: 600, y: 300 }, quarter, 160), { rightMm: 0, upMm: 0 });
  assert.deepEqual(viewPoint({ x: 800, y: 200 }, quarter, 160), { rightMm: 160, upMm: 80 });
  const narrow = surfacePart("surface-and-volume", { width: 400, height: 400 })!;
  assert.deepEqual(viewPoint({ x: 200, y: 200 }, narrow, 160), { rightMm: 80, upMm: 0 });
  const half = surfacePart("surface-and-volume", picture)!;
  assert.deepEqual(viewPoint({ x: 400, y: 0 }, half, 160), { rightMm: 80, upMm: 80 });
});

test("a point of the view goes back to its place in the picture", () => {
  for (const mode of ["surface", "surface-and-volume", "slices"]) {
    const part = surfacePart(mode, picture)!;
    const point = viewPoint({ x: 640, y: 90 }, part, 123.4);
    const { x, y } = pixelOf(point, part, 123.4);
    assert.ok(Math.hypot(x - 640, y - 90) < 0.1, `${mode}: ${x}, ${y}`);
  }
});

const lens = { fieldMm: 160, distanceMm: 50, perspective: true, openingDeg: 90 };

function near(actual: number, expected: number): void {
  assert.ok(Math.abs(actual - expected) < 1e-9, `${actual}, not ${expected}`);
}

test("side by side, all depths are as large", () => {
  assert.equal(scaleAt(-70, { ...lens, perspective: false }), 1);
});

test("in perspective what is at the target's depth is as large as without, and grows from the eye", () => {
  near(scaleAt(50, lens), 1); // the eye stands 80 mm before the target, 30 mm before the view plane
  near(scaleAt(130, lens), 2);
  near(scaleAt(10, lens), 0.5);
});

test("a lamp at the eye or behind it has a place too, and near the eye it does not fly off", () => {
  assert.equal(scaleAt(-30, lens), scaleAt(-29, lens));
  assert.ok(scaleAt(-30, lens) > 0);
  near(scaleAt(-110, lens), scaleAt(50, lens));
});

test("half the picture's height is a quarter turn, and the body follows the pointer", () => {
  assert.deepEqual(orbited({ yawDeg: 0, pitchDeg: 0 }, { x: 200, y: 0 }, 400), { yawDeg: -90, pitchDeg: 0 });
  assert.deepEqual(orbited({ yawDeg: 0, pitchDeg: 0 }, { x: 0, y: 100 }, 400), { yawDeg: 0, pitchDeg: 45 });
});

test("yaw goes round, pitch stops at the poles", () => {
  assert.deepEqual(orbited({ yawDeg: -170, pitchDeg: 80 }, { x: 40, y: 100 }, 360), { yawDeg: 170, pitchDeg: 90 });
});
