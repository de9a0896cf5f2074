// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { ServerClock } from "../src/server_clock";

test("the reply with the shortest round trip sets the clock", () => {
  const clock = new ServerClock();
  assert.equal(clock.at(0), undefined);
  clock.add(100, 5_130_000_000n, 160); // round trip of 60 ms, all of it before the server
  clock.add(200, 5_201_000_000n, 202); // round trip of 2 ms
  clock.add(300, 5_390_000_000n, 390);
  assert.equal(clock.at(1000), 6000);
});

test("old samples leave, so that a drifting clock is followed", () => {
  const clock = new ServerClock();
  clock.add(0, 1_000_000_000n, 0);
  for (let at = 1; at <= 60; ++at) clock.add(at, BigInt(at) * 1_000_000n + 2_000_000_000n, at + 2);
  assert.equal(clock.at(100), 2099);
  clock.reset();
  assert.equal(clock.at(100), undefined);
});
