// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { ViewSchema, type EchoLevels } from "../generated/fanlight_pb.js";
import { uncertainText } from "../src/uncertain_mark";

test("the mark says how much of the surface is uncertain", () => {
  const levels = { flat: false } as EchoLevels;
  assert.equal(uncertainText({ uncertainShare: 0.04, surfaceShare: 0.6, levels }), "");
  assert.equal(
    uncertainText({ uncertainShare: 0.254, surfaceShare: 0.6, levels }),
    "25 % of the surface is uncertain (dimmed)",
  );
});

test("the mark says that the surface is seen from where no beam came", () => {
  const view = create(ViewSchema, { matrix: [-1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1] });
  assert.equal(
    uncertainText({ uncertainShare: 0.97, surfaceShare: 0.6, view }),
    "Seen from behind, where few beams or none came: 97 % of the surface is dimmed",
  );
});

test("the mark says that a surface stands out from speckle alone", () => {
  const levels = { flat: true } as EchoLevels;
  assert.match(uncertainText({ uncertainShare: 0.5, surfaceShare: 0.3, levels }), /^Mostly speckle: .*\. 50 % of/);
  assert.equal(uncertainText({ uncertainShare: 0, surfaceShare: 0.001, levels }), "", "the notice says it");
  assert.equal(uncertainText({ uncertainShare: 0, surfaceShare: 0.3 }), "");
});
