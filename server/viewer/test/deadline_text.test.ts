// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { deadlineText } from "../src/deadline_text";

test("the measures that hold the rate are shown if there are any", () => {
  const text = (deadlineLevel: number, ...measures: string[]) => deadlineText({ deadlineLevel, measures });
  assert.equal(text(0), "");
  assert.equal(text(1), "level 1: full picture");
  assert.equal(text(3, "coarse picture", "wide step"), "level 3: coarse picture, wide step");
  assert.equal(text(0, "coarse picture"), "level 0: coarse picture");
});
