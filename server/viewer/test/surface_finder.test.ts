// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SurveyReplySchema } from "../generated/fanlight_pb.js";
import { SurfaceFinder } from "../src/surface_finder";

function made() {
  const seen = { asked: [] as bigint[], set: new Map<string, unknown>() };
  const found = { textContent: "", hidden: true };
  const button = { onclick: () => {}, ariaBusy: "false" };
  const settings = { setFound: (values: Map<string, unknown>) => void (seen.set = values) };
  const finder = new SurfaceFinder(
    button as unknown as HTMLButtonElement,
    (sentence) => Object.assign(found, { textContent: sentence, hidden: sentence === "" }),
    settings,
    (id) => seen.asked.push(id),
  );
  return { seen, button, found, finder };
}

test("a click asks, and what was found is set and shown", () => {
  const { seen, button, found, finder } = made();
  button.onclick();
  assert.deepEqual(seen.asked, [1n]);
  assert.equal(button.ariaBusy, "true");
  const scene = { scene: { camera: { yawDeg: 12 } }, choices: ["a sheet of 80 x 60 mm", "yaw 12 deg"] };
  finder.answered(create(SurveyReplySchema, { requestId: 1n, outcome: { case: "found", value: scene } }));
  assert.equal(seen.set.get("camera.yaw_deg"), 12);
  assert.equal(found.textContent, "Found a sheet of 80 x 60 mm; yaw 12 deg.");
  assert.equal(found.hidden, false);
  assert.equal(button.ariaBusy, "false");
  assert.equal(finder.found?.get("camera.yaw_deg"), 12);
  finder.reset();
  assert.equal(finder.found, undefined);
});

test("a refusal is shown and sets nothing", () => {
  const { seen, button, found, finder } = made();
  button.onclick();
  const refused = { message: "no surface stands out" };
  finder.answered(create(SurveyReplySchema, { requestId: 1n, outcome: { case: "refused", value: refused } }));
  assert.equal(found.textContent, "no surface stands out");
  assert.equal(seen.set.size, 0);
});

test("an answer to an older click is not taken", () => {
  const { button, found, finder } = made();
  button.onclick();
  button.onclick();
  const refused = { message: "no surface stands out" };
  finder.answered(create(SurveyReplySchema, { requestId: 1n, outcome: { case: "refused", value: refused } }));
  assert.equal(found.hidden, true);
});
