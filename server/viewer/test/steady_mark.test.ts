// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { steadyText } from "../src/steady_mark";

test("the mark says over how many volumes the surface is averaged, and nothing of one", () => {
  assert.equal(steadyText({ meanVolumes: 4.6 }), "Steady over 5 volumes");
  assert.equal(steadyText({ meanVolumes: 1.6 }), "Steady over 2 volumes");
  assert.equal(steadyText({ meanVolumes: 1.4 }), "");
  assert.equal(steadyText({ meanVolumes: 0 }), ""); // of a server that does not say it
});
