// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { offsetMm, paneTitle } from "../src/tomography";

test("nine planes lie at equal distances about the target", () => {
  assert.deepEqual(
    [0, 3, 4, 8].map((pane) => offsetMm(pane, 2.5)),
    [-10, -2.5, 0, 10],
  );
  const straight = { yawDeg: 0, pitchDeg: 0, rollDeg: 0 };
  assert.equal(paneTitle(2, 8, 0.1, straight), "C +0.4 mm");
  assert.equal(paneTitle(0, 0, 5, straight), "A \u221220 mm");
  assert.equal(paneTitle(1, 4, 5, { ...straight, rollDeg: 3 }), "B (turned) 0 mm");
  assert.equal(paneTitle(3, 5, 5, { ...straight, rollDeg: 3 }), "As seen +5 mm");
});
