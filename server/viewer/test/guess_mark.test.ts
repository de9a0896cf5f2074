// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import type { EchoLevels } from "../generated/fanlight_pb.js";
import { guessText } from "../src/guess_mark";

test("the mark says how much of the surface is a guess", () => {
  const levels = { flat: false } as EchoLevels;
  assert.equal(guessText({ guessedShare: 0.04, levels }, 0), "");
  assert.equal(guessText({ guessedShare: 0.254, levels }, 0), "25 % of the surface is a guess: dimmed");
});

test("the mark says that there is speckle only, where a threshold by hand could hide it", () => {
  const levels = { flat: true } as EchoLevels;
  assert.match(guessText({ guessedShare: 0, levels }, 12), /^Speckle only/);
  assert.equal(guessText({ guessedShare: 0, levels }, 0), "", "the notice says it");
  assert.equal(guessText({ guessedShare: 0 }, 12), "");
});
