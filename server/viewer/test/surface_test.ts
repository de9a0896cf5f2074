// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateSync } from "node:zlib";
import { create } from "@bufbuild/protobuf";
import { SurfaceSchema, ViewSchema } from "../generated/fanlight_pb.js";
import { lightPlan, type SceneValues } from "../src/surface/light_parameters";
import { coarser, kNoSurface, unpackSurface } from "../src/surface/surface_decoder";

const packed = (...bytes: number[]) => new Uint8Array(deflateSync(new Uint8Array(bytes)));

/** 4 x 3: a first row without surface, then rows that begin at 100 and 101 units; one far pixel at the end. */
function message() {
  return create(SurfaceSchema, {
    surfaceId: 9n,
    width: 4,
    height: 3,
    depthUnitMm: 0.02,
    runs: packed(4, 8),
    // Row 1: +100, 0, 0, 0. Row 2: +1, 0, 0, +1000. Folded: 200, 2, 2000. Rough are those next to +100 and +1.
    calmPixels: 5,
    residuals: packed(200, 0, 0, 0, 255, 0, 2, 0),
    largeResiduals: packed(0xd0, 0x07),
    certainties: packed(16, 16, 16, 1, 0, 16, 16, 16),
  });
}

test("a surface is read as it was packed", async () => {
  const map = await unpackSurface(message());
  const none = kNoSurface;
  assert.deepEqual([...map.depths.subarray(0, 4)], [none, none, none, none]);
  assert.deepEqual([...map.depths.subarray(4, 8)], [100, 100, 100, 100]);
  assert.deepEqual([...map.depths.subarray(8)], [101, 101, 101, 1101]);
  assert.deepEqual([...map.certainties], [0, 0, 0, 0, 255, 255, 255, 1, 0, 255, 255, 255]);
  assert.equal(map.nearestMm, 2);
  assert.equal(map.id, 9n);
});

test("a damaged surface is refused", async () => {
  const damages = [
    { runs: packed(4, 7) },
    { runs: new Uint8Array([1, 2, 3]) },
    { calmPixels: 4 },
    { residuals: packed(200, 0, 0) },
    { largeResiduals: packed() },
    { certainties: packed(16) },
  ];
  for (const damage of damages)
    await assert.rejects(unpackSurface(Object.assign(message(), damage)), JSON.stringify(Object.keys(damage)));
});

test("a coarser map has every n-th pixel of every n-th row", async () => {
  const half = coarser(await unpackSurface(message()), 2);
  assert.deepEqual([half.width, half.height], [2, 2]);
  assert.deepEqual([...half.depths], [kNoSurface, kNoSurface, 101, 101]);
});

test("a view is the same in parallel and in perspective at the depth of the target", () => {
  const numbers = new Map<string, number>(
    Object.entries({ "camera.distance_mm": 80, "rays.start_mm": 5, "rays.end_mm": 105, "light.depth_mm": -20 }),
  );
  const scene: SceneValues = { number: (name) => numbers.get(name) ?? 0, choice: () => "" };
  const part = { left: 10, top: 20, width: 100, height: 50 };
  const parallel = create(ViewSchema, { mmPerPixel: 0.25, middleColumn: 59.5, middleRow: 44.5 });
  const plan = lightPlan(scene, parallel, part, false);
  assert.deepEqual(plan.parameters.centre, [49.5, 24.5]);
  assert.equal(plan.parameters.pixel, 0.25);
  assert.equal(plan.parameters.shadow_top, -5);
  assert.equal(plan.perspective, false);
  const widening = create(ViewSchema, { ...parallel, mmPerPixel: 0.05, mmPerPixelPerMm: 0.0025 });
  const wide = lightPlan(scene, widening, part, false).parameters;
  assert.equal(wide.pixel, 0.25);
  assert.ok(Math.abs(Number(wide.view_scale_at_0) + 80 * Number(wide.view_scale_per_mm) - 1) < 1e-9);
  assert.equal(wide.eye_height, 20);
});
