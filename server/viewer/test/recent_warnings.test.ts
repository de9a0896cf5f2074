// SPDX-License-Identifier: Apache-2.0
import { create } from "@bufbuild/protobuf";
import assert from "node:assert/strict";
import { test } from "node:test";
import { SweepWarningSchema } from "../generated/fanlight_pb.js";
import { RecentWarnings } from "../src/recent_warnings";

const jump = create(SweepWarningSchema, { name: "jump", sentence: "It jumps." });
const rings = create(SweepWarningSchema, { name: "rings", sentence: "In air." });

test("a warning stays for five seconds after the last sweep that had it", () => {
  const recent = new RecentWarnings();
  assert.deepEqual(recent.take([], 0), []);
  assert.deepEqual(recent.take([jump], 100), [jump]);
  assert.deepEqual(recent.take([], 200), [jump]);
  assert.deepEqual(recent.take([jump, rings], 3000), [jump, rings]);
  assert.deepEqual(recent.take([rings], 7900), [jump, rings]);
  assert.deepEqual(recent.take([], 8100), [rings]);
  assert.deepEqual(recent.take([], 13_000), []);
});
