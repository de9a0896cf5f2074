// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { panesOf, type Axis } from "../src/plane_geometry";
import { alongTurned, angleAbout, isTurned, turnedInPane } from "../src/plane_turn";

const kStraight = { yawDeg: 0, pitchDeg: 0, rollDeg: 0 };
const kAxes: readonly Axis[] = ["x", "y", "z"];
const panes = panesOf("slices", { width: 400, height: 300 });

function near(a: Record<Axis, number>, b: Record<Axis, number>, what: string): void {
  for (const axis of kAxes) assert.ok(Math.abs(a[axis] - b[axis]) < 1e-3, `${what}: ${JSON.stringify([a, b])}`);
}

test("a turn in a pane leaves the pane's plane, and moves its content the way of the hand", () => {
  const before = { yawDeg: 20, pitchDeg: -15, rollDeg: 40 };
  for (const pane of panes) {
    const angle = 0.3;
    const after = turnedInPane(before, pane, angle);
    near(alongTurned(after, pane.fixed, 1), alongTurned(before, pane.fixed, 1), pane.name);
    // What lay to the right lies above the middle by that angle.
    const was = alongTurned(before, pane.right, 1);
    const along = (axis: Axis) => {
      const way = alongTurned(after, axis, 1);
      return kAxes.reduce((sum, each) => sum + was[each] * way[each], 0);
    };
    assert.ok(Math.abs(along(pane.right) - Math.cos(angle)) < 1e-3, pane.name);
    assert.ok(Math.abs(pane.up.sign * along(pane.up.axis) - Math.sin(angle)) < 1e-3, pane.name);
    assert.ok(isTurned(after));
  }
});

test("a turn and its opposite leave the planes along the sweep", () => {
  for (const pane of panes) assert.ok(!isTurned(turnedInPane(turnedInPane(kStraight, pane, 1), pane, -1)), pane.name);
});

test("an angle is counted counterclockwise as seen", () => {
  const middle = { x: 10, y: 10 };
  assert.equal(angleAbout(middle, { x: 20, y: 10 }, { x: 10, y: 0 }), Math.PI / 2);
});
