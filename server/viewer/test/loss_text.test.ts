// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { interpolatedText, mismatchText } from "../src/loss_text";

test("interpolated frames are shown from a tenth of the volume on", () => {
  const text = (framesMissing: number) =>
    interpolatedText({ framesMissing, firstFrameSequence: 100n, lastFrameSequence: 119n });
  assert.deepEqual([0, 1, 2, 5].map(text), ["", "", "2 of 20 frames interpolated", "5 of 20 frames interpolated"]);
});

test("a mismatch of forward and backward sweeps is shown if there is one", () => {
  const text = (mismatchDeg: number, mismatchLeftDeg: number, mismatchLeftMm: number) =>
    mismatchText({ mismatchDeg, mismatchLeftDeg, mismatchLeftMm });
  assert.equal(text(1.0204, 0.031, 0.0649), "corrected 1.02 deg, left 0.03 deg (0.06 mm)");
  assert.equal(text(-1, -0.004, 0), "corrected -1.00 deg, left 0.00 deg (0.00 mm)");
  assert.equal(text(0, 0, 0.01), "corrected 0.00 deg, left 0.00 deg (0.01 mm)");
  assert.equal(text(0, 0, 0), "");
  assert.equal(text(0.004, -0.004, 0), "");
});
