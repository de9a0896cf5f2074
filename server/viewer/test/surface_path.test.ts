// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { ViewSchema } from "../generated/fanlight_pb.js";
import { pathPixels, pixelOfPoint } from "../src/measuring/surface_path";
import { directions, scaleBar } from "../src/picture_marks";

test("a path has both of its ends, and few points between", () => {
  assert.deepEqual(pathPixels({ x: 3, y: 4 }, { x: 3, y: 4 }), [
    { x: 3, y: 4 },
    { x: 3, y: 4 },
  ]);
  const path = pathPixels({ x: 0, y: 0 }, { x: 30, y: -40 });
  assert.deepEqual(path[0], { x: 0, y: 0 });
  assert.deepEqual(path.at(-1), { x: 30, y: -40 });
  assert.equal(path.length, 18);
  assert.equal(pathPixels({ x: 0, y: 0 }, { x: 8000, y: 0 }).length, 1024);
});

// Looking along y from (1, 2, 3): right is x, down is -z; 0.5 mm a pixel, the middle at pixel (100, 50).
const view = create(ViewSchema, {
  matrix: [1, 0, 0, 1, 0, 0, 1, 2, 0, -1, 0, 3, 0, 0, 0, 1],
  mmPerPixel: 0.5,
  middleColumn: 100,
  middleRow: 50,
});

test("a point of the body is drawn at its pixel, in parallel and in perspective", () => {
  assert.deepEqual(pixelOfPoint([1, 60, 3], view), { x: 100, y: 50 });
  assert.deepEqual(pixelOfPoint([6, 60, 13], view), { x: 110, y: 30 });
  const perspective = { ...view, mmPerPixel: 0.1, mmPerPixelPerMm: 0.01 };
  assert.deepEqual(pixelOfPoint([6, 42, 3], perspective), { x: 110, y: 50 });
  assert.equal(pixelOfPoint([6, -20, 3], perspective), undefined);
});

test("the scale has a round length below a quarter of the picture", () => {
  assert.deepEqual(scaleBar(view, 512, 95), { mm: 50, pixels: 100 });
  assert.deepEqual(scaleBar({ ...view, mmPerPixel: 0.26 }, 512, 95), { mm: 20, pixels: 20 / 0.26 });
  assert.equal(scaleBar(undefined, 512, 95), undefined);
  assert.equal(scaleBar({ ...view, mmPerPixel: 0 }, 20, 0), undefined);
});

test("the probe's directions are converted to the picture's", () => {
  assert.deepEqual(directions(view), [
    { name: "side", right: 1, down: 0, away: 0 },
    { name: "depth", right: 0, down: 0, away: 1 },
    { name: "sweep", right: 0, down: -1, away: 0 },
  ]);
});
