// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { ProbeStatus_State } from "../generated/fanlight_pb.js";
import { ProbeWatch } from "../src/probe_watch";

const { ABSENT, STREAMING, LOST } = ProbeStatus_State;
const kServerAheadMs = 100_000;
const kWallAheadMs = 5_000_000;
const serverMs = (pageMs: number) => pageMs + kServerAheadMs;
const wallMs = (pageMs: number) => pageMs + kWallAheadMs;

/** A page that shows the last volume of a probe, which ended at 900; the probe was lost at 1000. */
function lostAt1000(): ProbeWatch {
  const watch = new ProbeWatch(serverMs, wallMs);
  watch.tell(STREAMING, 0);
  watch.show(serverMs(900));
  watch.tell(LOST, 1000);
  return watch;
}

test("without a probe, and with one that streams, there is nothing to say", () => {
  const watch = new ProbeWatch(serverMs, wallMs);
  for (const state of [ABSENT, STREAMING, STREAMING]) {
    watch.tell(state, 0);
    watch.show(serverMs(0));
    assert.deepEqual([watch.news(10), watch.isLive()], [undefined, true]);
  }
});

test("a loss is shown with its time, and no picture is live, however it was lit since", () => {
  const watch = lostAt1000();
  const lost = { state: "lost", since: { wallMs: wallMs(1000), seen: true } };
  assert.deepEqual(watch.news(1000), lost);
  watch.tell(LOST, 5000); // another field of the status changed
  watch.show(serverMs(900));
  assert.deepEqual(watch.news(60_000), lost);
  assert.equal(watch.isLive(), false);
  assert.equal(watch.ageMs(60_000), 59_100);
});

test("after a return the picture is live with the first volume since, and not with the last before", () => {
  const watch = lostAt1000();
  watch.tell(STREAMING, 9000);
  assert.deepEqual([watch.news(9000), watch.isLive()], [{ state: "back", pictureShown: false }, false]);
  watch.show(serverMs(900));
  assert.equal(watch.isLive(), false);
  watch.show(serverMs(9400));
  assert.deepEqual([watch.news(9500), watch.isLive()], [{ state: "back", pictureShown: true }, true]);
});

test("the return is said for a while, and until its first picture", () => {
  const watch = lostAt1000();
  watch.tell(STREAMING, 9000);
  assert.deepEqual(watch.news(60_000), { state: "back", pictureShown: false });
  watch.show(serverMs(9400));
  assert.deepEqual(watch.news(13_999), { state: "back", pictureShown: true });
  assert.equal(watch.news(14_000), undefined);
  assert.equal(watch.isLive(), true);
});

test("a second loss has a time of its own", () => {
  const watch = lostAt1000();
  watch.tell(STREAMING, 9000);
  watch.tell(LOST, 9100);
  assert.deepEqual(watch.news(9200), { state: "lost", since: { wallMs: wallMs(9100), seen: true } });
  assert.equal(watch.isLive(), false);
});

test("a page that comes while the probe is lost takes the time of the last volume, once it can", () => {
  let known = false;
  const watch = new ProbeWatch((pageMs) => (known ? serverMs(pageMs) : undefined), wallMs);
  watch.tell(LOST, 0);
  assert.deepEqual(watch.news(10), { state: "lost", since: undefined });
  watch.show(serverMs(-30_000));
  assert.deepEqual([watch.news(20), watch.ageMs(20)], [{ state: "lost", since: undefined }, undefined]);
  known = true;
  const lost = { state: "lost", since: { wallMs: wallMs(-30_000), seen: false } };
  assert.deepEqual(watch.news(30), lost);
  assert.equal(watch.isLive(), false);
  watch.tell(STREAMING, 100);
  assert.equal(watch.isLive(), false);
  watch.show(serverMs(300));
  assert.equal(watch.isLive(), true);
});

test("a new session begins without what the last one knew", () => {
  const watch = lostAt1000();
  watch.reset();
  assert.deepEqual([watch.news(2000), watch.isLive(), watch.ageMs(2000)], [undefined, true, undefined]);
});
