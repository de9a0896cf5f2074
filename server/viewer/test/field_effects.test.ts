// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SceneFieldSchema } from "../generated/fanlight_pb.js";
import { FieldEffects, unknownNames } from "../src/field_effects";
import type { Value } from "../src/scene";
import { SettingsEditor } from "../src/settings_editor";

const fields = [
  create(SceneFieldSchema, { name: "mode", choices: ["surface", "volume", "slice"] }),
  create(SceneFieldSchema, { name: "speckle.filter", choices: ["none", "box", "guided"] }),
  create(SceneFieldSchema, { name: "filter.kind", choices: ["mean", "edge-preserving"] }),
  create(SceneFieldSchema, { name: "light.normals", choices: ["three-neighbours", "central"] }),
  create(SceneFieldSchema, { name: "refresh", choices: ["volume", "frame"] }),
];

function missing(name: string, values: [string, Value][]): string | undefined {
  const editor = new SettingsEditor({ send: () => {}, changed: () => {}, refused: () => {}, accepted: () => {} });
  editor.start(fields, 1n, new Map(values));
  return new FieldEffects(editor).missing(name);
}

test("a group has an effect in the modes that show it", () => {
  assert.equal(missing("light", [["mode", 0]]), undefined);
  assert.equal(missing("light", [["mode", 1]]), "No effect unless mode is surface, surface and volume or slices.");
  assert.equal(missing("rays", [["mode", 1]]), undefined);
  assert.equal(missing("rays", [["mode", 2]]), "No effect while mode is slice or tomography.");
});

test("a field by itself has an effect where what it serves is chosen", () => {
  assert.equal(missing("speckle.size", [["speckle.filter", 0]]), "No effect while filter is none.");
  assert.equal(missing("speckle.size", [["speckle.filter", 1]]), undefined);
  assert.equal(missing("speckle.noise", [["speckle.filter", 1]]), "No effect unless filter is guided.");
  assert.equal(missing("shadow.softness_mm", [["shadow.coefficient", 1]]), "No effect unless coefficient is below 1.");
  assert.equal(missing("shadow.softness_mm", [["shadow.coefficient", 0.9]]), undefined);
});

test("a plane without a normal has no distance", () => {
  const normal = (x: number): [string, Value][] => [
    ["clip1.normal_x", x],
    ["clip1.normal_y", 0],
    ["clip1.normal_z", 0],
  ];
  const sentence = "No effect while normal x is 0, normal y is 0 and normal z is 0.";
  assert.equal(missing("clip1.distance_mm", normal(0)), sentence);
  assert.equal(missing("clip1.distance_mm", normal(-0.1)), undefined);
});

test("one of several reasons is enough", () => {
  const nothing: [string, Value][] = [
    ["filter.kind", 0],
    ["filter.islands", 1],
    ["filter.holes", 1],
    ["filter.steady", 0],
    ["refresh", 0],
    ["light.normals", 0],
    ["finish.outline", 0],
  ];
  assert.match(
    missing("filter.step_mm", nothing) ?? "",
    /kind is edge preserving, .* light, normals is central or finish, outline is above 0/,
  );
  for (const [name, value] of [
    ["filter.kind", 1],
    ["filter.holes", 3],
    ["filter.steady", 0.5],
    ["refresh", 1],
    ["light.normals", 1],
    ["finish.outline", 3],
  ]) {
    assert.equal(missing("filter.step_mm", [...nothing, [String(name), Number(value)]]), undefined, String(name));
  }
});

test("what is in no row, or whose need is not known, has an effect", () => {
  assert.equal(missing("camera.yaw_deg", []), undefined);
  assert.equal(missing("speckle.noise", []), undefined);
});

test("a name that the server does not offer is found", () => {
  const unknown = unknownNames(fields);
  assert.ok(unknown.includes("camera.projection"));
  assert.ok(unknown.includes("mode slices"));
  assert.ok(unknown.includes("transfer"));
  assert.ok(!unknown.includes("mode") && !unknown.includes("mode slice") && !unknown.includes("speckle.filter none"));
});
