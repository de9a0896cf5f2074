// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { legendColours, tickDepths } from "../src/depth_legend";

test("the ticks of a depth map are the depths of equal distances along its colours", () => {
  assert.deepEqual(tickDepths(0, 160), [0, 40, 80, 120, 160]);
  assert.deepEqual(tickDepths(10, 13), [10, 10.8, 11.5, 12.3, 13]);
});

test("its colours run from near, which is bright, to far", () => {
  assert.deepEqual(legendColours("none").slice(0, 1), ["rgb(100% 100% 100%)"]);
  assert.deepEqual(legendColours("gold"), [
    "rgb(100% 95% 70%)",
    "rgb(85% 55% 12%)",
    "rgb(45% 20% 2%)",
    "rgb(0% 0% 0%)",
  ]);
});
