// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { FrameWatch, noticeFor, notLiveText, type Condition } from "../src/notice";

const living: Condition = {
  connection: { state: "open" },
  probe: undefined,
  serverError: undefined,
  silentSeconds: undefined,
  source: "phantom:",
  sourceState: "running",
  pictureShown: true,
};

test("a living picture needs no words", () => {
  assert.equal(noticeFor(living), undefined);
});

test("what is worse hides what is less", () => {
  const bad: Condition = {
    ...living,
    probe: { state: "lost", since: undefined },
    serverError: "a message had no body",
    silentSeconds: 70,
    pictureShown: false,
  };
  assert.equal(noticeFor({ ...bad, connection: { state: "lost", sentence: "Gone.", retrying: true } })?.kind, "lost");
  assert.equal(noticeFor(bad)?.kind, "probe-lost");
  bad.probe = { state: "back", pictureShown: false };
  assert.equal(noticeFor(bad)?.kind, "error");
  assert.equal(noticeFor({ ...bad, serverError: undefined })?.kind, "probe-back");
  bad.probe = undefined;
  assert.equal(noticeFor({ ...bad, serverError: undefined })?.kind, "silent");
  assert.equal(noticeFor({ ...living, pictureShown: false })?.kind, "waiting");
});

test("a source that is over says so, whether it ended or failed", () => {
  const silent: Condition = { ...living, silentSeconds: 4 };
  assert.equal(noticeFor({ ...silent, sourceState: "ended" })?.title, "The source has ended");
  const failed = noticeFor({ ...silent, sourceState: "the probe is gone" });
  assert.deepEqual([failed?.kind, failed?.detail], ["error", "the probe is gone"]);
});

test("a probe that is plugged in and not read says why", () => {
  const probe = { state: "lost", since: undefined } as const;
  const notice = noticeFor({ ...living, probe, probeTrouble: "the probe counts no volumes, expected one that does" });
  assert.match(notice?.detail ?? "", /is not read: the probe counts no volumes, expected one that does\.$/);
});

test("a lost probe says since when, as well as that is known", () => {
  const wallMs = new Date(2026, 10, 20, 9, 5, 7).getTime();
  const told = (since: { wallMs: number; seen: boolean } | undefined) =>
    noticeFor({ ...living, silentSeconds: 8, sourceState: "probe lost", probe: { state: "lost", since } });
  assert.equal(told({ wallMs, seen: true })?.title, "Probe lost");
  assert.equal(
    told({ wallMs, seen: true })?.detail,
    "Since 09:05:07. The picture goes on by itself when the probe is plugged in again.",
  );
  assert.match(told({ wallMs, seen: false })?.detail ?? "", /^Since about 09:05:07\. The picture goes on/);
  assert.match(told(undefined)?.detail ?? "", /^The picture goes on/);
});

test("a probe that is back is no failed source, though the statistics still have it lost", () => {
  const back: Condition = { ...living, sourceState: "probe lost", probe: { state: "back", pictureShown: false } };
  assert.equal(noticeFor(back)?.detail, "Waiting for its first volume.");
  assert.equal(noticeFor({ ...back, probe: { state: "back", pictureShown: true } })?.kind, "probe-back");
  assert.equal(noticeFor({ ...back, probe: undefined }), undefined);
});

test("a picture that stands still tells its age", () => {
  assert.equal(notLiveText(undefined), "Not live");
  assert.equal(notLiveText(48_900), "Not live, 48 s old");
  assert.equal(notLiveText(125_000), "Not live, 2 min old");
  assert.equal(notLiveText(3 * 3_600_000), "Not live, 3 h old");
});

test("frames that stop coming are noticed, and their return too", () => {
  const frames = new FrameWatch();
  assert.equal(frames.silentSeconds(99_000), undefined);
  frames.count(35n, 1000);
  frames.count(35n, 2000);
  assert.equal(frames.silentSeconds(3000), undefined);
  frames.count(35n, 4000);
  assert.equal(frames.silentSeconds(4000), 3);
  frames.count(36n, 5000);
  assert.equal(frames.silentSeconds(5000), undefined);
});
