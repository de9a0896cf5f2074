// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { alongAxisMm, boxNear, depthTicks, panesOf, pixelAlong, valueAlong, withinPane } from "../src/plane_geometry";
import { slicePoint } from "../src/slice_click";

const size = { width: 400, height: 300 };
const target = { x: 5, y: 80, z: -10 };
const kFieldMm = 75; // of a pane 150 pixels high: 0.5 mm a pixel

test("a place of a pane's axis is where a click on the slice finds it", () => {
  const camera = {
    fieldMm: kFieldMm,
    distanceMm: 80,
    perspective: false,
    openingDeg: 30,
    target,
    yawDeg: 0,
    pitchDeg: 0,
    rollDeg: 0,
    sliceDepthMm: 80,
    planes: { yawDeg: 0, pitchDeg: 0, rollDeg: 0 },
    plane: 0,
    stepMm: 5,
  };
  for (const pane of panesOf("slices", size)) {
    const { left, top } = pane.part;
    const pixel = { x: left + 40, y: top + 90 };
    const point = slicePoint(pixel, "slices", size, camera)!;
    assert.equal(valueAlong(pane, pane.right, pixel.x, target, kFieldMm), point[pane.right], pane.name);
    assert.equal(valueAlong(pane, pane.up.axis, pixel.y, target, kFieldMm), point[pane.up.axis], pane.name);
    assert.equal(pixelAlong(pane, pane.right, point[pane.right], target, kFieldMm), pixel.x);
    assert.equal(pixelAlong(pane, pane.up.axis, point[pane.up.axis], target, kFieldMm), pixel.y);
    assert.equal(point[pane.fixed], target[pane.fixed]);
  }
  assert.deepEqual(panesOf("surface", size), []);
});

test("a depth scale has round steps and begins at the probe's face", () => {
  const [a, , c] = panesOf("slices", size);
  const ticks = depthTicks(a!, target, kFieldMm);
  assert.deepEqual(
    ticks.map(({ depthMm }) => depthMm),
    [60, 80, 100],
  );
  assert.equal(ticks[1]!.row, 75);
  const nearFace = depthTicks(a!, { ...target, y: 10 }, kFieldMm);
  assert.equal(nearFace[0]!.depthMm, 0);
  assert.deepEqual(depthTicks(c!, target, kFieldMm), [], "C lies at one depth");
});

test("an open side can be taken at the pane's border", () => {
  const [, b] = panesOf("slices", size);
  assert.equal(withinPane(b!, true, pixelAlong(b!, "z", 1000, target, kFieldMm)), 398);
  assert.equal(withinPane(b!, false, pixelAlong(b!, "y", -1000, target, kFieldMm)), 2);
});

test("the drawn box has its sides, or the edge of the field where one is open", () => {
  const sides: Record<string, number> = { "crop.left_mm": -10, "crop.right_mm": 1000 };
  const box = boxNear(target, 100, (name) => sides[name] ?? (/below|near/.test(name) ? -1000 : 1000));
  assert.deepEqual(box.x, [-10, 53]);
  assert.deepEqual(box.y, [32, 128]);
});

test("a drag moves a face along its own direction on the screen", () => {
  assert.equal(alongAxisMm({ x: 30, y: 40 }, { x: 3, y: 4 }), 10);
  assert.equal(alongAxisMm({ x: 40, y: -30 }, { x: 3, y: 4 }), 0, "across it");
  assert.equal(alongAxisMm({ x: 40, y: -30 }, { x: 0, y: 0 }), 0);
});
