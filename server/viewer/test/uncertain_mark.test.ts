// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import type { EchoLevels } from "../generated/fanlight_pb.js";
import { uncertainText } from "../src/uncertain_mark";

test("the mark says how much of the surface is uncertain", () => {
  const levels = { flat: false } as EchoLevels;
  assert.equal(uncertainText({ uncertainShare: 0.04, surfaceShare: 0.6, levels }), "");
  assert.equal(
    uncertainText({ uncertainShare: 0.254, surfaceShare: 0.6, levels }),
    "25 % of the surface is uncertain (dimmed)",
  );
});

test("the mark says that a surface stands out from speckle alone", () => {
  const levels = { flat: true } as EchoLevels;
  assert.match(uncertainText({ uncertainShare: 0.5, surfaceShare: 0.3, levels }), /^Mostly speckle: .*\. 50 % of/);
  assert.equal(uncertainText({ uncertainShare: 0, surfaceShare: 0.001, levels }), "", "the notice says it");
  assert.equal(uncertainText({ uncertainShare: 0, surfaceShare: 0.3 }), "");
});
