// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SceneFieldSchema } from "../generated/fanlight_pb.js";
import { hintOf, labelOf, numberText, sliderRange } from "../src/field_text";

test("labels drop the group and the unit", () => {
  assert.equal(labelOf("light.right_mm"), "Right");
  assert.equal(labelOf("camera.target_x_mm"), "Target x");
  assert.equal(labelOf("clip1.normal_x"), "Normal x");
  assert.equal(labelOf("mode"), "Mode");
});

test("numbers are as short as they can be", () => {
  assert.deepEqual([40, 0.1 + 0.2, -65.536, 163.84, NaN].map(numberText), ["40", "0.3", "-65.54", "163.84", ""]);
});

test("a hint has the meaning, the range and the default", () => {
  const size = create(SceneFieldSchema, {
    help: "side of the average",
    unit: "pixels",
    minimum: 1,
    maximum: 31,
    step: 2,
  });
  assert.equal(hintOf(size, 7), "side of the average; 1 to 31 pixels, default 7");
  const choices = ["either", "dark-to-bright"];
  const sign = create(SceneFieldSchema, { help: "which way", maximum: 1, step: 1, choices });
  assert.equal(hintOf(sign, 1), "which way; default dark to bright");
  const points = create(SceneFieldSchema, { help: "colours", isText: true });
  assert.equal(hintOf(points, "0 #000000 0"), "colours; default 0 #000000 0");
});

test("a slider covers what can be aimed at", () => {
  const right = create(SceneFieldSchema, { unit: "mm", minimum: -2000, maximum: 2000 });
  assert.deepEqual(sliderRange(right, 163.84), { low: -327, high: 327.68, step: 1 });
  const shadow = create(SceneFieldSchema, { minimum: 0, maximum: 1 });
  assert.deepEqual(sliderRange(shadow, 163.84), { low: 0, high: 1, step: 0.01 });
});
