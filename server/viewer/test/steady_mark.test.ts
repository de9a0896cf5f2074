// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { SteadyMark, steadyText } from "../src/steady_mark";

test("the mark says how much of the surface is averaged, and over how many volumes", () => {
  const text = (steadyShare: number, meanVolumes: number): string =>
    steadyText({ steadyShare, meanVolumes, seamFrames: 0 });
  assert.equal(text(0.97, 4.6), "Surface steady over 5 volumes");
  assert.equal(text(0.8, 1.6), "80 % of the surface steady over 2 volumes");
  assert.equal(text(0.05, 3), "");
  assert.equal(text(0, 1), "");
  assert.equal(text(0, 0), ""); // of a server that does not say it
});

test("the mark says over how many frames two sweeps are blended", () => {
  const text = (seamFrames: number): string => steadyText({ steadyShare: 0, meanVolumes: 1, seamFrames });
  assert.equal(text(6), "Sweeps blended over 6 frames");
  assert.equal(text(1), "Sweeps blended over 1 frame");
});

test("the mark does not flicker between two numbers", () => {
  const mark = { textContent: "", hidden: true };
  const marks = new SteadyMark(mark as unknown as HTMLElement);
  for (const [meanVolumes, volumes] of [
    [3.4, 3],
    [3.6, 3],
    [4.4, 4],
    [3.8, 4],
    [1, 0],
  ] as const) {
    marks.show({ steadyShare: 1, meanVolumes, seamFrames: 0 });
    assert.equal(mark.textContent, volumes ? `Surface steady over ${volumes} volumes` : "");
  }
});
