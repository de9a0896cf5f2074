import assert from "node:assert/strict";
import { test } from "node:test";
import { FrameWatch, noticeFor, type Condition } from "../src/notice";

const living: Condition = {
  connection: { state: "open" },
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
  const bad: Condition = { ...living, serverError: "probe unplugged", silentSeconds: 70, pictureShown: false };
  assert.equal(noticeFor({ ...bad, connection: { state: "lost", sentence: "Gone.", retrying: true } })?.kind, "lost");
  assert.equal(noticeFor(bad)?.kind, "error");
  assert.equal(noticeFor({ ...bad, serverError: undefined })?.kind, "silent");
  assert.equal(noticeFor({ ...living, pictureShown: false })?.kind, "waiting");
});

test("a source that is over says so, whether it ended or failed", () => {
  const silent: Condition = { ...living, silentSeconds: 4 };
  assert.equal(noticeFor({ ...silent, sourceState: "ended" })?.title, "The source has ended");
  const failed = noticeFor({ ...silent, sourceState: "the probe is gone" });
  assert.deepEqual([failed?.kind, failed?.detail], ["error", "the probe is gone"]);
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
