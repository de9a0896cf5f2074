// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SceneFieldSchema } from "../generated/fanlight_pb.js";
import { jsonOf, valuesFromJson } from "../src/own_presets";
import { inPlainWords, titlesOf } from "../src/refusal_text";

const fields = [
  create(SceneFieldSchema, { name: "mode", choices: ["surface", "slices"] }),
  create(SceneFieldSchema, { name: "light.up_mm", maximum: 10 }),
  create(SceneFieldSchema, { name: "light.ambient", maximum: 1 }),
  create(SceneFieldSchema, { name: "detector.threshold", maximum: 255 }),
  create(SceneFieldSchema, { name: "transfer.points", isText: true }),
];

test("a preset goes to the JSON of /api/scene and back", () => {
  const values = new Map<string, number | string>([
    ["mode", 1],
    ["light.up_mm", 3.5],
    ["light.ambient", 0],
    ["transfer.points", "0 #000000 0"],
  ]);
  const json = jsonOf(values, fields);
  assert.deepEqual(json, {
    mode: "slices",
    light: { up_mm: 3.5, ambient: 0 },
    transfer: { points: "0 #000000 0" },
  });
  assert.deepEqual(valuesFromJson(JSON.stringify(json), fields), values);
  assert.deepEqual(valuesFromJson(JSON.stringify({ revision: 3, scene: json }), fields), values, "as it is answered");
});

test("a file that is no preset is refused with what is wrong", () => {
  const refused = (text: string, sentence: RegExp) => assert.throws(() => valuesFromJson(text, fields), sentence);
  refused("{", /the file is not JSON/);
  refused("[]", /it has no fields/);
  refused("null", /it has no fields/);
  refused('{"light": {"nope": 1}}', /there is no field light\.nope/);
  refused('{"mode": "hologram"}', /mode cannot be "hologram"/);
  refused('{"light": {"up_mm": "high"}}', /light\.up_mm cannot be "high"/);
  refused('{"transfer": {"points": 3}}', /transfer\.points cannot be 3/);
  refused('{"light": {"up_mm": {"deep": 1}}}', /cannot be/);
});

test("a refusal names a field as the page does", () => {
  const titles = titlesOf(fields);
  assert.equal(
    inPlainWords("detector.threshold is 999, expected 0 to 255", titles),
    "Threshold is 999, expected 0 to 255",
  );
  assert.equal(inPlainWords("light.up_mm is 99, expected -1 to 1.5", titles), "Light: Up is 99, expected -1 to 1.5");
  assert.equal(inPlainWords("display 3 is in control", titles), "Display 3 is in control");
});
