// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { fitOf } from "../src/measuring/answered_picture";

const picture = (pictureId: bigint, change = {}) => ({
  pictureId,
  volumeId: 7n,
  sceneRevision: 3n,
  privateView: false,
  ...change,
});

test("an answer fits the picture that was clicked, whatever is shown now", () => {
  assert.equal(fitOf(20n, picture(20n), picture(20n)), "fits");
  assert.equal(fitOf(20n, picture(20n), picture(21n, { volumeId: 8n })), "fits");
});

test("an answer for the fine picture waits for it, and fits once it is shown", () => {
  assert.equal(fitOf(21n, picture(20n), picture(20n)), "awaited");
  assert.equal(fitOf(21n, picture(20n), picture(21n)), "fits");
});

test("an answer for another scene, volume or view does not fit", () => {
  for (const change of [{ volumeId: 8n }, { sceneRevision: 4n }, { privateView: true }])
    assert.equal(fitOf(21n, picture(20n), picture(21n, change)), "changed");
  assert.equal(fitOf(21n, picture(20n), picture(22n)), "changed", "a picture was passed over: unknown");
  assert.equal(fitOf(19n, picture(20n), picture(21n)), "changed");
});
