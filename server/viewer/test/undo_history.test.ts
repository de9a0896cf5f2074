// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { UndoHistory } from "../src/undo_history";

const values = (threshold: number) => new Map([["detector.threshold", threshold]]);

test("changes are taken back and made again, in their order", () => {
  const history = new UndoHistory();
  history.add(values(1), values(2), 0);
  history.add(values(2), values(3), 5000);
  assert.deepEqual(history.undo(), values(2));
  assert.deepEqual(history.undo(), values(1));
  assert.equal(history.undo(), undefined);
  assert.deepEqual(history.redo(), values(2));
  assert.deepEqual(history.redo(), values(3));
  assert.equal(history.canRedo, false);
});

test("the changes of one drag are one", () => {
  const history = new UndoHistory();
  for (let step = 0; step < 50; ++step) history.add(values(step), values(step + 1), 100 * step);
  assert.deepEqual(history.undo(), values(0));
  assert.deepEqual(history.redo(), values(50));
});

test("a hand that is lifted ends a change", () => {
  const history = new UndoHistory();
  history.add(values(1), values(2), 0);
  history.endGesture();
  history.add(values(2), values(3), 100);
  assert.deepEqual(history.undo(), values(2));
  assert.deepEqual(history.undo(), values(1));
});

test("all changes between the fall and the lift of a hand are one, also where it rests", () => {
  const history = new UndoHistory();
  const angles = (yaw: number, pitch: number) =>
    new Map([
      ["camera.yaw_deg", yaw],
      ["camera.pitch_deg", pitch],
    ]);
  history.add(values(1), values(2), 0);
  history.beginGesture();
  history.add(values(2), values(3), 100);
  history.add(new Map([["camera.yaw_deg", 0]]), new Map([["camera.yaw_deg", 10]]), 5000);
  history.add(angles(10, 0), angles(20, 30), 10_000);
  history.endGesture();
  history.add(values(3), values(4), 10_001);
  assert.deepEqual(history.undo(), values(3));
  assert.deepEqual(history.undo(), new Map([...values(2), ...angles(0, 0)]));
  assert.deepEqual(history.undo(), values(1));
  assert.deepEqual(history.redo(), values(2));
  assert.deepEqual(history.redo(), new Map([...values(3), ...angles(20, 30)]));
});

test("what belongs to a gesture is one change, also after the hand was lifted", () => {
  const history = new UndoHistory();
  const [stroke, another] = [{}, {}];
  history.add(values(1), values(2), 0, stroke);
  history.endGesture();
  history.add(values(2), values(3), 5000, stroke);
  history.add(values(3), values(4), 5001, another);
  history.add(values(4), values(5), 5002);
  assert.deepEqual(history.undo(), values(4));
  assert.deepEqual(history.undo(), values(3));
  assert.deepEqual(history.undo(), values(1));
});

test("changes of other fields, or later ones, are their own", () => {
  const history = new UndoHistory();
  history.add(values(1), values(2), 0);
  history.add(new Map([["mode", 0]]), new Map([["mode", 4]]), 100);
  history.add(new Map([["mode", 4]]), new Map([["mode", 1]]), 2000);
  assert.deepEqual(history.undo(), new Map([["mode", 4]]));
  assert.deepEqual(history.undo(), new Map([["mode", 0]]));
});

test("a new change forgets what could be made again, and 20 are kept", () => {
  const history = new UndoHistory();
  for (let step = 0; step < 30; ++step) history.add(values(step), values(step + 1), 10_000 * step);
  history.undo();
  history.add(values(29), values(99), 1e6);
  assert.equal(history.canRedo, false);
  let undone = 0;
  while (history.undo()) ++undone;
  assert.equal(undone, 20);
});

test("a change that was refused is no change", () => {
  const history = new UndoHistory();
  history.add(values(1), values(2), 0);
  history.add(values(2), values(999), 5000);
  history.drop();
  assert.deepEqual(history.undo(), values(1));
});
