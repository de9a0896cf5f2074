// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateSync } from "node:zlib";
import { create } from "@bufbuild/protobuf";
import { SurfaceSchema, ViewSchema } from "../generated/fanlight_pb.js";
import { lightPlan, type SceneValues } from "../src/surface/light_parameters";
import { DrawingPace } from "../src/surface/drawing_pace";
import { agreement, depthGrid } from "../src/surface/depth_grid";
import { KeptPictures, type KeptPicture } from "../src/surface/kept_pictures";
import { coarser, kNoSurface, unpackSurface, type DepthMap } from "../src/surface/surface_decoder";
import { meshOf } from "../src/surface/surface_mesh";
import { coarserView, degreesBetween, isFiner, sameView, turnBetween, viewOf } from "../src/surface/view_of";

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
    certainties: packed(16, 1, 0, 130, 16), // of 2 x 2 pixels, from the first row on
  });
}

test("a surface is read as it was packed", async () => {
  const map = await unpackSurface(message());
  const none = kNoSurface;
  assert.deepEqual([...map.depths.subarray(0, 4)], [none, none, none, none]);
  assert.deepEqual([...map.depths.subarray(4, 8)], [100, 100, 100, 100]);
  assert.deepEqual([...map.depths.subarray(8)], [101, 101, 101, 1101]);
  assert.deepEqual([...map.certainties], [0, 0, 0, 0, 255, 255, 1, 1, 0, 0, 255, 0]);
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

function mapOf(width: number, depths: number[]): DepthMap {
  const height = depths.length / width;
  const certainties = new Uint8Array(depths.length).fill(255);
  return { id: 1n, width, height, depths: new Uint16Array(depths), unitMm: 0.01, certainties, nearestMm: 1 };
}

test("a mesh has no triangle without a surface, and those over a step at the end", () => {
  const none = kNoSurface;
  const { indices, surfaceIndices } = meshOf(mapOf(4, [100, 110, 900, none, 105, 112, 905, none]), 1);
  // Two of the first column of cells, two over the step, and of the last column none.
  assert.equal(surfaceIndices, 6);
  assert.equal(indices.length, 12);
  assert.deepEqual([...indices.subarray(0, 6)], [0, 1, 4, 5, 4, 1]);
  const over = new Set(indices.subarray(6));
  assert.deepEqual([...over].sort(), [1, 2, 5, 6]);
});

/** A scene with this camera. */
function seen(camera: Record<string, number>, projection = "parallel"): SceneValues {
  const usual = { distance_mm: 80, field_mm: 120, opening_deg: 30, target_y_mm: 70 };
  const values = new Map(Object.entries({ ...usual, ...camera }));
  const choice = (name: string) => (name === "camera.projection" ? projection : "surface");
  return { number: (name) => values.get(name.replace("camera.", "")) ?? 0, choice };
}

test("a view is that of the renderer", () => {
  const part = { left: 0, top: 0, width: 64, height: 60 };
  const view = viewOf(seen({}), part);
  // Right is x, down is -z, forward is y; the view plane stands 80 mm before the target.
  assert.deepEqual(
    view.matrix.map((value) => value + 0),
    [1, 0, 0, 0, 0, 0, 1, -10, 0, -1, 0, 0, 0, 0, 0, 1],
  );
  assert.equal(view.mmPerPixel, 2);
  assert.deepEqual([view.middleColumn, view.middleRow], [31.5, 29.5]);
  const wide = viewOf(seen({}, "perspective"), part);
  assert.ok(Math.abs(wide.mmPerPixel + 80 * wide.mmPerPixelPerMm - 2) < 1e-9, "the field holds at the target");
  const half = coarserView(wide, 2);
  assert.equal(half.mmPerPixel, 2 * wide.mmPerPixel);
  assert.equal(half.middleColumn, 15.75);
});

test("a turn keeps the target where it is", () => {
  const part = { left: 0, top: 0, width: 64, height: 64 };
  const [from, to] = [viewOf(seen({}), part), viewOf(seen({ yaw_deg: 25, pitch_deg: -10 }), part)];
  assert.ok(sameView(from, viewOf(seen({}), part)));
  assert.ok(!sameView(from, to));
  assert.ok(Math.abs(degreesBetween(from, viewOf(seen({ yaw_deg: 25 }), part)) - 25) < 1e-9);
  const m = turnBetween(from, to);
  const target = [0, 1, 2].map((row) => m[8 + row]! * 80 + m[12 + row]!);
  for (const [axis, value] of [0, 0, 80].entries()) assert.ok(Math.abs(target[axis]! - value) < 1e-9, `axis ${axis}`);
  // What lies to the right of the target comes nearer or goes farther, and keeps its length.
  const right = [0, 1, 2].map((row) => m[row]!);
  assert.ok(Math.abs(Math.hypot(...right) - 1) < 1e-9);
});

test("a slow browser draws coarsely, a quick one does not", () => {
  const square = (side: number) => ({ width: side, height: side });
  const usual = square(512);
  /** Draws as often as that in a browser that takes `fullMs` for a picture of the usual size. */
  const draw = (pace: DrawingPace, pictures: number, fullMs: number) => {
    for (let picture = 0; picture < pictures; ++picture) {
      const level = pace.levelOf(usual);
      pace.learn(square(512 / level), fullMs / level ** 2);
    }
  };
  const quick = new DrawingPace();
  assert.equal(quick.levelOf(usual), 1);
  assert.equal(quick.mostPixels, Infinity);
  draw(quick, 5, 4);
  assert.equal(quick.levelOf(usual), 1);
  assert.equal(quick.levelOf(square(2048)), 2);
  assert.ok(quick.mostPixels > 2048 ** 2);
  const slow = new DrawingPace();
  draw(slow, 1, 130);
  assert.equal(slow.levelOf(usual), 2);
  draw(slow, 20, 400);
  assert.equal(slow.levelOf(usual), 4);
  assert.equal(slow.levelOf(square(2048)), 14);
  assert.ok(slow.mostPixels < 520 ** 2);
  assert.equal(slow.isTooSlow, false);
  const slowest = new DrawingPace();
  slowest.learn(square(170), 300);
  assert.ok(slowest.isTooSlow);
  draw(slow, 30, 20);
  assert.equal(slow.levelOf(usual), 1);
  const stalled = new DrawingPace();
  draw(stalled, 5, 400);
  stalled.learn(square(128), 2000);
  assert.equal(stalled.isTooSlow, false, "one stall is no pace");
  for (let picture = 0; picture < 5; ++picture) stalled.learn(square(128), 2000);
  assert.ok(stalled.isTooSlow);
});

test("a picture of the same view with more pixels is finer", () => {
  const part = { left: 0, top: 0, width: 512, height: 512 };
  const more = { left: 0, top: 0, width: 1024, height: 1024 };
  const picture = (rectangle: typeof part, yaw_deg = 0) => ({
    view: viewOf(seen({ yaw_deg }), rectangle),
    height: rectangle.height,
  });
  assert.ok(isFiner(picture(more), picture(part)));
  assert.ok(!isFiner(picture(part), picture(more)));
  assert.ok(!isFiner(picture(part), picture(part)));
  assert.ok(!isFiner(picture(more, 5), picture(part)), "another view");
  const zoomed = { view: viewOf(seen({ field_mm: 159.9 }), more), height: more.height };
  assert.ok(!isFiner(zoomed, picture(part)), "another field");
});

test("two pictures agree where both show the same surface, or none", () => {
  const of = (depths: number[]) => depthGrid({ width: 4, height: 1 }, (column) => depths[column]!);
  const before = of([50, 50, -1, -1]);
  assert.deepEqual([...agreement(before, of([51.9, 52.1, -1, 50]), 2)], [255, 0, 255, 0]);
  assert.equal(
    agreement(
      before,
      depthGrid({ width: 2, height: 1 }, () => 50),
      2,
    ).length,
    0,
  );
  const coarse = depthGrid({ width: 960, height: 480 }, (column, row) => column + row / 1000);
  assert.deepEqual([coarse.width, coarse.height], [96, 96]);
  assert.ok(Math.abs(coarse.depthsMm[97]! - 15.007) < 1e-4, "the middle of its pixels");
});

test("kept pictures stay within their memory, the oldest go first", () => {
  const kept = new KeptPictures(3 * 24);
  const picture = (volumeId: bigint) => ({ picture: { volumeId }, map: mapOf(4, Array(8).fill(1)), castKey: "" });
  for (const id of [1n, 2n, 3n]) kept.add(picture(id) as KeptPicture);
  kept.add(picture(1n) as KeptPicture); // again
  kept.add(picture(4n) as KeptPicture);
  assert.deepEqual(
    [1n, 2n, 3n, 4n].map((id) => kept.of(id) !== undefined),
    [true, false, true, true],
  );
  kept.clear();
  assert.equal(kept.of(1n), undefined);
});
