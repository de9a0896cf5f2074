// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SceneFieldSchema } from "../generated/fanlight_pb.js";
import { fullTitle, namesOf, sections } from "../src/settings_layout";

function laidOut(...names: string[]): [string, string[]][] {
  const fields = names.map((name) => create(SceneFieldSchema, { name }));
  return sections(fields).map(({ title, settings }) => [title, settings.flatMap(namesOf)]);
}

test("groups stand in the order of use, unknown ones after them", () => {
  assert.deepEqual(laidOut("novel.thing", "camera.yaw_deg", "clip1.normal_x", "detector.sign", "mode", "light.up_mm"), [
    ["Picture", ["mode"]],
    ["Surface detector", ["detector.sign"]],
    ["Light", ["light.up_mm"]],
    ["Camera", ["camera.yaw_deg"]],
    ["Clip plane 1", ["clip1.normal_x"]],
    ["Novel", ["novel.thing"]],
  ]);
});

test("what is reached for most stands on top, once", () => {
  assert.deepEqual(laidOut("shadow.coefficient", "shadow.softness_mm", "detector.threshold", "mode"), [
    ["Picture", ["mode", "detector.threshold", "shadow.coefficient"]],
    ["Shadow", ["shadow.softness_mm"]],
  ]);
});

test("red, green and blue in a row are one colour, other fields their own", () => {
  const kinds = (...names: string[]) =>
    sections(names.map((name) => create(SceneFieldSchema, { name })))[1]!.settings.map((setting) =>
      setting.kind === "colour" ? `${setting.name}: ${namesOf(setting).join(" ")}` : setting.field.name,
    );
  assert.deepEqual(kinds("light.kind", "light.red", "light.green", "light.blue", "light.ambient"), [
    "light.kind",
    "light.colour: light.red light.green light.blue",
    "light.ambient",
  ]);
  assert.deepEqual(kinds("dye.red", "dye.blue", "dye.green"), ["dye.red", "dye.blue", "dye.green"]);
  assert.deepEqual(kinds("dye.red", "dye.green"), ["dye.red", "dye.green"]);
  assert.deepEqual(kinds("dye.infrared", "dye.green", "dye.blue"), ["dye.infrared", "dye.green", "dye.blue"]);
});

test("out of its section a field is called by both", () => {
  assert.equal(fullTitle("clip2.normal_x"), "Clip plane 2, normal x");
  assert.equal(fullTitle("mode"), "Mode");
});
