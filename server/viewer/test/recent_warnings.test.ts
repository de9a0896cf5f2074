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
  assert.deepEqual(recent.recent(0), []);
  recent.take([jump], 100);
  recent.take([], 200);
  assert.deepEqual(recent.recent(3000), [jump]);
  recent.take([rings], 3000);
  assert.deepEqual(recent.recent(5000), [jump, rings]);
  assert.deepEqual(recent.recent(60_000), [rings], "its sweep is still shown");
  recent.take([], 60_000);
  assert.deepEqual(recent.recent(60_001), []);
});
