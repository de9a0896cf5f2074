// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { FluidRegionSchema } from "../generated/fanlight_pb.js";
import { borderIn, depthAt, regionGrid } from "../src/measuring/region_border";
import { pixelOf } from "../src/view_geometry";

const kRadiusMm = 12;
const kMiddle = [3, 70, -4] as const;

/** A ball on a grid of 2 mm; its depths are distances, 1 mm for 10. */
function ball() {
  const side = 16;
  const at = (axis: 0 | 1 | 2, cell: number) => kMiddle[axis] + 2 * (cell - (side - 1) / 2);
  const depths = Uint8Array.from({ length: side ** 3 }, (_, index) => {
    const place = [index % side, Math.floor(index / side) % side, Math.floor(index / side ** 2)];
    const away = Math.hypot(...([0, 1, 2] as const).map((axis) => at(axis, place[axis]!) - kMiddle[axis]));
    return Math.min(255, Math.max(0, Math.round(128 + 10 * (kRadiusMm - away))));
  });
  const first = { firstXMm: at(0, 0), firstYMm: at(1, 0), firstZMm: at(2, 0) };
  return create(FluidRegionSchema, { ...first, stepMm: 2, columns: side, rows: side, slices: side, depths });
}

/** A plane at right angles to z, `aside` mm from the middle of the ball; x to the right, y downwards. */
function plane(aside: number) {
  return {
    name: "plane A",
    part: { left: 10, top: 20, width: 200, height: 200 },
    fieldMm: 100,
    centre: { x: 0, y: 75, z: kMiddle[2] + aside },
    right: { x: 1, y: 0, z: 0 },
    up: { x: 0, y: -1, z: 0 },
  };
}

test("the border of a ball is a circle in each plane that passes through it", () => {
  const grid = regionGrid(ball())!;
  for (const aside of [0, 5, -9]) {
    const shown = plane(aside);
    const segments = borderIn(grid, shown);
    const middle = pixelOf({ rightMm: kMiddle[0], upMm: 75 - kMiddle[1] }, shown.part, shown.fieldMm);
    const radius = Math.sqrt(kRadiusMm ** 2 - aside ** 2) * 2; // 2 pixels a mm
    const distances = segments.flat().map(({ x, y }) => Math.hypot(x - middle.x, y - middle.y));
    for (const distance of distances) assert.ok(Math.abs(distance - radius) < 0.8, `${distance}, not ${radius}`);
    const length = segments.reduce((sum, [from, to]) => sum + Math.hypot(to.x - from.x, to.y - from.y), 0);
    assert.ok(Math.abs(length / (2 * Math.PI * radius) - 1) < 0.03, `closed: ${length}`);
  }
  assert.deepEqual(borderIn(grid, plane(13)), []);
  // What lies beyond the pane is not drawn.
  const near = { ...plane(0), part: { left: 10, top: 20, width: 100, height: 200 } };
  assert.ok(borderIn(grid, near).every((ends) => ends.every(({ x }) => x < 110)));
});

test("depths are linear between cells, and 0 outside of them", () => {
  const grid = regionGrid(ball())!;
  const [x, y, z] = grid.first;
  const cell = (index: number) => grid.depths[index]!;
  assert.equal(depthAt(grid, [x, y, z]), cell(0));
  const inside = 7 + 7 * 16 + 7 * 256;
  const at = (i: number) => depthAt(grid, [x + 2 * i, y + 14, z + 14]);
  assert.equal(at(7.5), (cell(inside) + cell(inside + 1)) / 2);
  assert.equal(at(-0.1), 0);
  assert.equal(at(15.1), 0);
  assert.equal(at(15), cell(15 + 7 * 16 + 7 * 256));
});

test("a region whose numbers contradict each other is none", () => {
  for (const wrong of [{ columns: 15 }, { stepMm: 0 }, { stepMm: NaN }, { rows: 4096, columns: 1 }, { slices: 0 }])
    assert.equal(regionGrid(Object.assign(ball(), wrong)), undefined, JSON.stringify(wrong));
});
