// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import {
  CineStatus_State as State,
  CineStatusSchema,
  EchoLevelsSchema,
  type CineStatus,
} from "../generated/fanlight_pb.js";
import { cineTexts } from "../src/cine_bar";
import { linePoints } from "../src/plots";
import { kQuick, thresholdRange } from "../src/quick_settings";
import { bodyWay } from "../src/view_geometry";

test("each slider shows what it has set, and more is more", () => {
  for (const { field, range, toField, toShown } of kQuick) {
    for (const shown of range ?? [5, 50, 100])
      assert.ok(Math.abs(toShown(toField(shown)) - shown) < (range ? 0.5 : 1), `${field} at ${shown}`);
  }
  const [, smooth, steady, brightness, shadow] = kQuick;
  assert.deepEqual([steady!.toField(1), steady!.toField(5)], [0, 0.8]); // one volume: the filter is off
  assert.ok(smooth!.toField(80) > smooth!.toField(20));
  assert.ok(brightness!.toField(80) > brightness!.toField(20));
  assert.equal(brightness!.toField(50), 2.1);
  assert.ok(brightness!.toField(0) >= 0.1 && brightness!.toField(100) <= 8); // what the field takes
  assert.deepEqual([shadow!.toField(0), shadow!.toField(100)], [1, 0]); // the field is the light that is left
  assert.ok(smooth!.toField(0) > 0); // 0 mm would take the size in pixels
});

test("the threshold's slider covers the volume's own grey levels, and the value in force", () => {
  const levels = create(EchoLevelsSchema, { fluid: 7.3, tissue: 107 });
  assert.deepEqual(thresholdRange(levels, 20), { low: 7, high: 127 });
  assert.deepEqual(thresholdRange(levels, 200), { low: 7, high: 200 });
  assert.deepEqual(thresholdRange(levels, 3), { low: 3, high: 127 });
  assert.deepEqual(thresholdRange(undefined, 20), { low: 1, high: 255 });
});

test("the cine says which volume is shown, and how long before the newest", () => {
  const status = { state: State.FROZEN, volumes: 20, volume: 2, timeS: 0.4, durationS: 3.6 };
  const text = (change: Partial<Pick<CineStatus, "volume" | "volumes" | "timeS">>) =>
    cineTexts(create(CineStatusSchema, { ...status, ...change })).join("");
  assert.equal(text({}), "volume 3 of 20, 3.2 s before the newest");
  assert.equal(text({ volume: 19, timeS: 3.6 }), "volume 20 of 20");
  assert.equal(text({ volumes: 1, volume: 0 }), "volume 1 of 1");
});

test("a plot ends at its right edge with the newest value", () => {
  assert.equal(linePoints([0, 10], 10), "239.0,38.0 240.0,2.0");
});

test("a way in the view is one in the body", () => {
  const front = { yawDeg: 0, pitchDeg: 0, rollDeg: 0 };
  assert.deepEqual(bodyWay(front, 3, 4, 5), { x: 3, y: 5, z: 4 });
  const near = (way: { x: number; y: number; z: number }, expected: number[]) =>
    [way.x, way.y, way.z].forEach((value, axis) => assert.ok(Math.abs(value - expected[axis]!) < 1e-9));
  near(bodyWay({ ...front, yawDeg: 90 }, 3, 0, 0), [0, 3, 0]);
  near(bodyWay({ ...front, pitchDeg: 90 }, 0, 4, 0), [0, 4, 0]);
  near(bodyWay({ ...front, rollDeg: 90 }, 3, 0, 0), [0, 0, -3]);
});
