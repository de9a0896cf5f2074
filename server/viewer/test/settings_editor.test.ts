// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SceneFieldSchema } from "../generated/fanlight_pb.js";
import type { Value, Values } from "../src/scene";
import { SettingsEditor } from "../src/settings_editor";

const fields = [create(SceneFieldSchema, { name: "a", choices: ["none", "some"] })];

function started(): { editor: SettingsEditor; sent: [bigint, [string, Value][]][]; refusals: string[] } {
  const sent: [bigint, [string, Value][]][] = [];
  const refusals: string[] = [];
  const editor = new SettingsEditor({
    send: (id, values) => sent.push([id, [...values]]),
    changed: () => {},
    refused: (sentence) => refusals.push(sentence),
    accepted: () => {},
  });
  editor.start(fields, 7n, scene(1, 10));
  return { editor, sent, refusals };
}

function scene(a: number, b: number): Values {
  return new Map([
    ["a", a],
    ["b", b],
  ]);
}

test("a drag sends its first value, then only its newest once that was answered", () => {
  const { editor, sent } = started();
  for (let value = 2; value <= 9; ++value) editor.set([["a", value]]);
  assert.deepEqual(sent, [[1n, [["a", 2]]]]);
  assert.equal(editor.get("a"), 9);
  editor.acceptedReply(1n, 8n, scene(2, 10));
  assert.deepEqual(sent.at(-1), [2n, [["a", 9]]]);
  assert.equal(editor.get("a"), 9);
  editor.acceptedReply(2n, 9n, scene(9, 10));
  assert.equal(sent.length, 2);
  assert.equal(editor.get("a"), 9);
});

test("values of several fields wait together", () => {
  const { editor, sent } = started();
  editor.set([["a", 2]]);
  editor.set([["a", 3]]);
  editor.set([["b", 11]]);
  editor.acceptedReply(1n, 8n, scene(2, 10));
  assert.deepEqual(sent.at(-1), [
    2n,
    [
      ["a", 3],
      ["b", 11],
    ],
  ]);
});

test("what is in force already is not sent", () => {
  const { editor, sent } = started();
  editor.set([["a", 1]]);
  assert.equal(sent.length, 0);
});

test("a drag back to the value in force is sent after the change it undoes", () => {
  const { editor, sent } = started();
  editor.set([["a", 2]]);
  editor.set([["a", 1]]);
  assert.equal(editor.get("a"), 1);
  editor.acceptedReply(1n, 8n, scene(2, 10));
  assert.deepEqual(sent.at(-1), [2n, [["a", 1]]]);
});

test("a picture is the asked one when nothing is under way and its revision is the newest", () => {
  const { editor } = started();
  assert.deepEqual([editor.isChanging(), editor.isShownBy(7n)], [false, true]);
  editor.set([["a", 2]]);
  assert.deepEqual([editor.isChanging(), editor.isShownBy(7n)], [true, false]);
  editor.acceptedReply(1n, 8n, scene(2, 10));
  assert.equal(editor.isShownBy(7n), false);
  assert.equal(editor.isShownBy(8n), true);
});

test("without revisions an answer counts as it comes, also where it is not what was asked for", () => {
  const { editor, sent } = started();
  editor.start(fields, 0n, scene(1, 10));
  editor.set([["b", 10.4]]);
  assert.deepEqual(sent, [[1n, [["b", 10.4]]]]);
  editor.acceptedReply(1n, 0n, scene(1, 10.5));
  assert.deepEqual([editor.get("b"), editor.isChanging()], [10.5, false]);
  editor.adopt(0n, scene(1, 12));
  assert.equal(editor.get("b"), 12);
});

test("a refusal is shown and restores the value in force", () => {
  const { editor, refusals } = started();
  editor.set([["a", 999]]);
  editor.refusedReply(1n, "a is 999, expected at most 100");
  assert.deepEqual(refusals, ["a is 999, expected at most 100"]);
  assert.equal(editor.get("a"), 1);
});

test("a refusal does not hold up what waits", () => {
  const { editor, sent } = started();
  editor.set([["a", 999]]);
  editor.set([["a", 50]]);
  editor.refusedReply(1n, "too much");
  assert.deepEqual(sent.at(-1), [2n, [["a", 50]]]);
  assert.equal(editor.get("a"), 50);
});

test("a reply to another request changes nothing", () => {
  const { editor, sent } = started();
  editor.set([["a", 2]]);
  editor.set([["a", 3]]);
  editor.acceptedReply(99n, 8n, scene(5, 5));
  assert.equal(sent.length, 1);
  assert.equal(editor.get("b"), 10);
});

test("another display's change is shown, unless it is older or this page has a newer value", () => {
  const { editor } = started();
  editor.set([["a", 2]]);
  editor.adopt(9n, scene(5, 50));
  assert.deepEqual([editor.get("a"), editor.get("b")], [2, 50]);
  editor.adopt(8n, scene(6, 60));
  assert.equal(editor.get("b"), 50);
});

test("a lost connection takes back what was not answered; a new session starts over", () => {
  const { editor, sent } = started();
  editor.set([["a", 2]]);
  editor.set([["a", 3]]);
  editor.stop();
  assert.equal(editor.get("a"), 1);
  editor.set([["a", 4]]);
  assert.equal(sent.length, 1);
  editor.start(fields, 1n, scene(70, 80));
  assert.equal(editor.get("a"), 70);
  editor.acceptedReply(1n, 8n, scene(2, 10));
  assert.equal(editor.get("a"), 70);
});

test("a number, a choice and a text are each read as what they are", () => {
  const { editor, sent } = started();
  editor.adopt(8n, new Map<string, Value>([...scene(1, 10), ["words", "0 #000000 0"]]));
  assert.deepEqual([editor.number("b"), editor.choice("a"), editor.text("words")], [10, "some", "0 #000000 0"]);
  assert.deepEqual([editor.number("words"), editor.choice("b"), editor.text("a")], [NaN, "", ""]);
  assert.deepEqual([editor.get("none"), editor.number("none"), editor.text("none")], [undefined, NaN, ""]);
  editor.set([["words", "nonsense"]]);
  assert.deepEqual(sent, [[1n, [["words", "nonsense"]]]]);
  editor.refusedReply(1n, "words: point 1 cannot be read");
  assert.equal(editor.text("words"), "0 #000000 0");
});
