// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { ControlRequest_Wish as Wish, ControlStateSchema, Role } from "../generated/fanlight_pb.js";
import { controlText } from "../src/control_bar";

const kSelf = 2n;
const anna = { holderSession: 1n, holderName: "Anna" };

function text(role: Role, state: MessageInitShape<typeof ControlStateSchema>) {
  return controlText(create(ControlStateSchema, state), role, kSelf);
}

test("a viewer watches, no matter who is in control", () => {
  assert.deepEqual(text(Role.VIEWER, {}), { text: "Watching", mayChange: false });
  assert.equal(text(Role.VIEWER, anna).text, "Watching; Anna (display 1) is in control");
  assert.equal(text(Role.VIEWER, anna).offer, undefined);
});

test("an operator changes settings if no one else is in control, and otherwise requests control", () => {
  assert.deepEqual(text(Role.OPERATOR, {}), { text: "", mayChange: true });
  const other = text(Role.OPERATOR, anna);
  assert.equal(other.mayChange, false);
  assert.equal(other.offer?.wish, Wish.ASK);
  const asked = text(Role.OPERATOR, { ...anna, asking: [{ session: kSelf, name: "Ben" }] });
  assert.equal(asked.offer?.wish, Wish.RELEASE);
});

test("an admin takes over", () => {
  assert.equal(text(Role.ADMIN, anna).offer?.wish, Wish.TAKE_OVER);
});

test("who is in control hands it to who asked first, or gives it up", () => {
  const mine = { holderSession: kSelf, holderName: "Ben", mine: true };
  assert.equal(text(Role.OPERATOR, mine).offer?.wish, Wish.RELEASE);
  const asking = [
    { session: 7n, name: "Cleo" },
    { session: 8n, name: "Dora" },
  ];
  const asked = text(Role.OPERATOR, { ...mine, asking });
  assert.deepEqual(asked.offer, { label: "Hand over", wish: Wish.GRANT, toSession: 7n });
  assert.equal(asked.mayChange, true);
});
