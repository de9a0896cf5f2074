import assert from "node:assert/strict";
import { test } from "node:test";
import { orbited, pictureFraction, viewPoint } from "../src/view_geometry";

const picture = { left: 100, top: 50, width: 800, height: 400 };

test("the centre is the origin, right and up are positive, the height is the field", () => {
  assert.deepEqual(viewPoint({ x: 500, y: 250 }, picture, 160), { rightMm: 0, upMm: 0 });
  assert.deepEqual(viewPoint({ x: 900, y: 50 }, picture, 160), { rightMm: 160, upMm: 80 });
  assert.deepEqual(viewPoint({ x: 100, y: 450 }, picture, 160), { rightMm: -160, upMm: -80 });
});

test("a point of the view goes back to its place in the picture", () => {
  assert.deepEqual(pictureFraction({ rightMm: 0, upMm: 0 }, 2, 160), { x: 0.5, y: 0.5 });
  assert.deepEqual(pictureFraction({ rightMm: -160, upMm: 80 }, 2, 160), { x: 0, y: 0 });
});

test("half the picture's height is a quarter turn, and the body follows the pointer", () => {
  assert.deepEqual(orbited({ yawDeg: 0, pitchDeg: 0 }, { x: 200, y: 0 }, 400), { yawDeg: -90, pitchDeg: 0 });
  assert.deepEqual(orbited({ yawDeg: 0, pitchDeg: 0 }, { x: 0, y: 100 }, 400), { yawDeg: 0, pitchDeg: 45 });
});

test("yaw goes round, pitch stops at the poles", () => {
  assert.deepEqual(orbited({ yawDeg: -170, pitchDeg: 80 }, { x: 40, y: 100 }, 360), { yawDeg: 170, pitchDeg: 90 });
});
