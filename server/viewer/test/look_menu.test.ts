// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { LookSchema } from "../generated/fanlight_pb.js";
import { lookOf } from "../src/look_menu";
import type { Value } from "../src/scene";
import { SettingsEditor } from "../src/settings_editor";

const looks = [
  create(LookSchema, { name: "skin", scene: { light: { ambient: 0.1 }, finish: { tone: 1 } } }),
  create(LookSchema, { name: "paper", scene: { light: { ambient: 0.2 }, finish: { tone: 0 } } }),
];

function shown(values: [string, Value][]): string {
  const editor = new SettingsEditor({ send: () => {}, changed: () => {}, refused: () => {}, accepted: () => {} });
  editor.start([], 1n, new Map(values));
  return lookOf(looks, editor);
}

test("a look is known by all of its fields", () => {
  assert.equal(shown([["light.ambient", 0.2], ["finish.tone", 0], ["mode", 3]]), "paper"); // prettier-ignore
  assert.equal(shown([["light.ambient", 0.2], ["finish.tone", 1], ["mode", 3]]), ""); // prettier-ignore
  assert.equal(shown([]), "");
});
