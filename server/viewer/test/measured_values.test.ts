// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import type { EchoLevels } from "../generated/fanlight_pb.js";
import { MeasuredValues } from "../src/measured_values";

const kLevels = { fluid: 7, tissue: 142, noise: 21.04, threshold: 21.6, leastTissue: 61, linear: false } as EchoLevels;

function measured(values: Record<string, number>): MeasuredValues {
  return new MeasuredValues({ number: (name: string) => values[name] ?? NaN, choice: () => "guided" });
}

test("a field that is 0 has the value of the picture's data", () => {
  const values = measured({
    "detector.threshold": 0,
    "detector.least_tissue": 0,
    "speckle.levels": 0,
    "speckle.noise": 0,
  });
  assert.equal(values.text("detector.threshold"), "");
  assert.equal(values.take(kLevels), true);
  assert.equal(values.valueOf("detector.threshold"), 21.6);
  assert.equal(values.text("detector.threshold"), "Now 21.6, from the data: fluid 7, tissue 142.");
  assert.equal(values.text("detector.least_tissue"), "Now 61, from the data: fluid 7, tissue 142.");
  assert.equal(values.text("speckle.levels"), "Now 21, from the data.");
  assert.equal(values.take(kLevels), false);
  assert.equal(values.valueOf("filter.size"), undefined);
});

test("a field that the user has set is not measured", () => {
  const values = measured({ "detector.threshold": 30, "speckle.levels": 0, "speckle.noise": 0.5 });
  values.take(kLevels);
  assert.equal(values.valueOf("detector.threshold"), undefined);
  assert.equal(values.valueOf("speckle.levels"), undefined, "the speckle's deviation is a share of its mean");
});

test("the noise of frames that are not log-compressed is a share of the tissue", () => {
  const values = measured({ "speckle.levels": 0, "speckle.noise": 0 });
  values.take({ ...kLevels, noise: 71, linear: true });
  assert.equal(values.valueOf("speckle.noise"), 0.5);
  assert.equal(values.valueOf("speckle.levels"), undefined);
});

test("frames that show nothing give no value", () => {
  const values = measured({ "detector.threshold": 0 });
  values.take(kLevels);
  assert.equal(values.take(undefined), true);
  assert.equal(values.text("detector.threshold"), "");
});
