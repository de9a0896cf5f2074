// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { LookSchema } from "../generated/fanlight_pb.js";
import { PresetBar } from "../src/preset_bar";
import type { Value, Values } from "../src/scene";
import type { SettingsEditor } from "../src/settings_editor";

const kFace = create(LookSchema, {
  name: "face",
  scene: { detector: { sign: 0, threshold: 0 }, light: { ambient: 0.1 } },
  foundFields: ["detector.sign", "detector.threshold"],
});
const kBone = create(LookSchema, {
  name: "bone",
  scene: { detector: { sign: 1, threshold: 0 }, light: { ambient: 0.4 } },
});

/** A bar without its buttons, and the values that it sets. */
function made(found: Values) {
  const values = new Map<string, Value>();
  const editor = {
    get: (name: string) => values.get(name),
    set: (wanted: Iterable<readonly [string, Value]>) => {
      for (const [name, value] of wanted) values.set(name, value);
    },
  };
  const buttons: { value: string; onclick(): void }[] = [];
  const root = {
    replaceChildren: (...children: typeof buttons) => buttons.splice(0, buttons.length, ...children),
    querySelectorAll: () => buttons,
  };
  globalThis.document = { createElement: () => ({ dataset: {}, append: () => {} }) } as unknown as Document;
  const bar = new PresetBar(root as unknown as HTMLFieldSetElement, editor as unknown as SettingsEditor, () => found);
  bar.start([kFace, kBone]);
  const press = (name: string) => buttons.find((button) => button.value === name)!.onclick();
  return { bar, values, press };
}

test("a preset of skin shows the surface that was found", () => {
  const { values, press } = made(new Map([["detector.sign", 1], ["detector.threshold", 22]])); // prettier-ignore
  press("bone");
  assert.equal(values.get("detector.threshold"), 0);
  press("face");
  assert.equal(values.get("detector.sign"), 1);
  assert.equal(values.get("detector.threshold"), 22);
  assert.ok(Math.abs(Number(values.get("light.ambient")) - 0.1) < 1e-6);
});

test("bone keeps what it looks for where a surface is found", () => {
  const { bar, values, press } = made(new Map());
  press("bone");
  bar.setFound(new Map<string, Value>([["detector.sign", 0], ["detector.threshold", 35], ["camera.yaw_deg", 12]])); // prettier-ignore
  assert.equal(values.get("detector.sign"), 1);
  assert.equal(values.get("camera.yaw_deg"), 12);
  press("face");
  bar.setFound(new Map<string, Value>([["detector.sign", 1]]));
  assert.equal(values.get("detector.sign"), 1);
});
