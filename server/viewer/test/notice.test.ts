// SPDX-License-Identifier: Apache-2.0
import { create } from "@bufbuild/protobuf";
import assert from "node:assert/strict";
import { test } from "node:test";
import { SweepWarningSchema } from "../generated/fanlight_pb.js";
import type { LivenessNews } from "../src/liveness";
import { noticeFor, type Condition } from "../src/notice";

const live: LivenessNews = { state: "live", ageMs: 300, title: "", detail: "" };
const silent: LivenessNews = { state: "not-live", ageMs: 70_000, title: "No new frames", detail: "None for 70 s." };

const living: Condition = {
  connection: { state: "open" },
  probe: undefined,
  serverError: undefined,
  liveness: live,
  source: "phantom:",
  pictureShown: true,
};

test("a living picture needs no words", () => {
  assert.equal(noticeFor(living), undefined);
});

test("frames that look wrong are named, and few frames are not put over the picture", () => {
  const warning = (name: string, sentence: string) => create(SweepWarningSchema, { name, sentence });
  const warnings = [warning("jump", "It jumps."), warning("mirrored", "It is mirrored."), warning("sparse", "Few.")];
  assert.equal(noticeFor({ ...living, warnings })?.title, "Check the probe");
  assert.equal(noticeFor({ ...living, warnings, hasNoSurface: true })?.detail, "It jumps. It is mirrored.");
  assert.equal(noticeFor({ ...living, warnings: [warning("sparse", "Few.")] }), undefined);
});

test("what is worse hides what is less", () => {
  const bad: Condition = {
    ...living,
    probe: { state: "lost", since: undefined },
    serverError: "a message had no body",
    liveness: silent,
    pictureShown: false,
  };
  assert.equal(noticeFor({ ...bad, connection: { state: "lost", sentence: "Gone.", retrying: true } })?.kind, "lost");
  assert.equal(noticeFor(bad)?.kind, "probe-lost");
  bad.probe = { state: "back", pictureShown: false };
  assert.equal(noticeFor(bad)?.kind, "error");
  assert.equal(noticeFor({ ...bad, serverError: undefined })?.kind, "probe-back");
  bad.probe = undefined;
  assert.equal(noticeFor({ ...bad, serverError: undefined })?.kind, "not-live");
  assert.equal(noticeFor({ ...living, pictureShown: false })?.kind, "waiting");
});

test("a picture that is not live says why, and that the last volume stays", () => {
  const notice = noticeFor({ ...living, liveness: silent });
  assert.equal(notice?.title, "No new frames");
  assert.equal(notice?.detail, "None for 70 s. The last volume is still shown.");
  assert.equal(noticeFor({ ...living, liveness: silent, pictureShown: false })?.detail, "None for 70 s.");
  const delayed: LivenessNews = { state: "delayed", ageMs: 5000, title: "Delayed", detail: "Slow." };
  assert.equal(noticeFor({ ...living, liveness: delayed }), undefined, "the mark says it");
});

test("a probe that is plugged in and not read says why", () => {
  const probe = { state: "lost", since: undefined } as const;
  const notice = noticeFor({ ...living, probe, probeTrouble: "the probe counts no volumes, expected one that does" });
  assert.match(notice?.detail ?? "", /cannot be used: the probe counts no volumes, expected one that does\.$/);
});

test("a lost probe says since when, as well as that is known", () => {
  const wallMs = new Date(2026, 10, 20, 9, 5, 7).getTime();
  const told = (since: { wallMs: number; seen: boolean } | undefined) =>
    noticeFor({ ...living, liveness: silent, probe: { state: "lost", since } });
  assert.equal(told({ wallMs, seen: true })?.title, "Probe lost");
  assert.equal(
    told({ wallMs, seen: true })?.detail,
    "Since 09:05:07. The picture resumes when the probe is connected again.",
  );
  assert.match(told({ wallMs, seen: false })?.detail ?? "", /^Since about 09:05:07\. The picture resumes/);
  assert.match(told(undefined)?.detail ?? "", /^The picture resumes/);
});

test("a probe that is back says so, before its first volume", () => {
  const back: Condition = { ...living, probe: { state: "back", pictureShown: false } };
  assert.equal(noticeFor(back)?.detail, "Waiting for its first volume.");
  assert.equal(noticeFor({ ...back, probe: { state: "back", pictureShown: true } })?.kind, "probe-back");
  assert.equal(noticeFor({ ...back, probe: undefined }), undefined);
});
