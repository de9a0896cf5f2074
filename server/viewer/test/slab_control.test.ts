// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { slabText } from "../src/slab_control";

test("a thick plane says what it shows", () => {
  assert.equal(slabText(0, 1), "");
  assert.equal(slabText(10, 0), "Planes: Mean of 10 mm");
  assert.equal(slabText(2, 2), "Planes: X-ray of 2 mm");
});
