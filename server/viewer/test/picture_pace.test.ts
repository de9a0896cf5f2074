// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { PicturePace } from "../src/picture_pace";

const kServerAheadMs = 100_000;
const serverMs = (pageMs: number) => pageMs + kServerAheadMs;

test("an even stream has its rate at every moment", () => {
  const pace = new PicturePace(serverMs);
  for (let atMs = 0; atMs <= 4000; atMs += 500) pace.add(atMs, 0);
  for (const nowMs of [4000, 4100, 4400]) assert.equal(pace.perSecond(nowMs), 2);
});

test("a stream that stopped has no rate", () => {
  const pace = new PicturePace(serverMs);
  assert.equal(pace.perSecond(0), 0);
  for (let atMs = 0; atMs <= 1000; atMs += 50) pace.add(atMs, 0);
  assert.equal(pace.perSecond(10_000), 0);
});

test("the age is the median of a second, then that of the standing picture", () => {
  const pace = new PicturePace(serverMs);
  assert.equal(pace.ageMs(0), undefined);
  const add = (atMs: number, ageMs: number) => pace.add(atMs, serverMs(atMs) - ageMs);
  add(0, 500);
  add(1200, 30);
  add(1400, 10);
  add(1600, 20);
  assert.equal(pace.ageMs(1700), 20);
  assert.equal(pace.ageMs(6600), 5020);
});

test("without the server's clock there is no age, and with it the earlier pictures have theirs", () => {
  let known = false;
  const pace = new PicturePace((pageMs) => (known ? serverMs(pageMs) : undefined));
  pace.add(0, serverMs(0) - 40);
  assert.equal(pace.ageMs(10), undefined);
  known = true;
  assert.equal(pace.ageMs(10), 40);
});

test("a stream slower than the window has a rate too, until its next picture is long due", () => {
  const pace = new PicturePace((pageMs) => pageMs);
  for (let atMs = 0; atMs <= 12000; atMs += 4000) pace.add(atMs, 0);
  assert.equal(pace.perSecond(15000), 0.25);
  assert.equal(pace.perSecond(20001), 0);
});
