// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SceneStateSchema, ViewStateSchema } from "../generated/fanlight_pb.js";
import { OwnView } from "../src/own_view";

function made() {
  const box = { checked: false, onchange: () => {} };
  const told: string[] = [];
  const view = new OwnView({ querySelector: () => box } as unknown as HTMLElement, {
    chosen: () => told.push("chosen"),
    leave: () => told.push("leave"),
    backTo: (main) => told.push(`back to ${main.revision}`),
  });
  view.mainIs(create(SceneStateSchema, { revision: 4n }));
  const choose = (checked: boolean) => {
    box.checked = checked;
    box.onchange();
  };
  return { view, told, choose };
}

test("a view that was never opened is left without a word to the server", () => {
  const { view, told, choose } = made();
  choose(true);
  assert.equal(view.wanted, true);
  choose(false);
  assert.deepEqual(told, ["chosen", "back to 4"]);
});

test("an open one is left with a word, and the main view's scene is back", () => {
  const { view, told, choose } = made();
  choose(true);
  assert.equal(view.tell(create(ViewStateSchema, { isPrivate: true })), "");
  assert.equal(view.isOpen, true);
  choose(false);
  assert.equal(view.isOpen, false);
  assert.deepEqual(told, ["chosen", "leave", "back to 4"]);
});

test("one that opens only after it was left is left again", () => {
  const { view, told, choose } = made();
  choose(true);
  choose(false);
  view.tell(create(ViewStateSchema, { isPrivate: true }));
  assert.equal(view.isOpen, false);
  assert.deepEqual(told, ["chosen", "back to 4", "leave"]);
});

test("one that the server ends says why", () => {
  const { view, told, choose } = made();
  choose(true);
  view.tell(create(ViewStateSchema, { isPrivate: true }));
  assert.equal(
    view.tell(create(ViewStateSchema, { ended: "this machine had no time for it for 5 s" })),
    "Your own view has ended: this machine had no time for it for 5 s.",
  );
  assert.equal(view.wanted || view.isOpen, false);
  assert.deepEqual(told, ["chosen", "back to 4"]);
});
