// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { SteadyMark, steadyText } from "../src/steady_mark";

test("the mark says how much of the surface is averaged, and over how many volumes", () => {
  assert.equal(steadyText({ steadyShare: 0.97, meanVolumes: 4.6 }), "Surface steady over 5 volumes");
  assert.equal(steadyText({ steadyShare: 0.8, meanVolumes: 1.6 }), "80 % of the surface steady over 2 volumes");
  assert.equal(steadyText({ steadyShare: 0.05, meanVolumes: 3 }), "");
  assert.equal(steadyText({ steadyShare: 0, meanVolumes: 1 }), "");
  assert.equal(steadyText({ steadyShare: 0, meanVolumes: 0 }), ""); // of a server that does not say it
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
    marks.show({ steadyShare: 1, meanVolumes });
    assert.equal(mark.textContent, volumes ? `Surface steady over ${volumes} volumes` : "");
  }
});
