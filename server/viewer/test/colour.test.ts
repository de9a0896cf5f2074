// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { hexOf, partsOf } from "../src/colour";

test("every colour comes back", () => {
  for (let level = 0; level < 256; ++level) {
    const hex = `#${level.toString(16).padStart(2, "0")}ff00`;
    assert.equal(hexOf(partsOf(hex)), hex);
  }
});

test("what is out of range is as near as can be, what is unknown black", () => {
  assert.equal(hexOf([-1, 0.5, 2]), "#0080ff");
  assert.equal(hexOf([NaN, NaN, NaN]), "#000000");
});
