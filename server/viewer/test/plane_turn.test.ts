// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { panesOf, type Axis } from "../src/plane_geometry";
import { alongTurned, angleAbout, isTurned, movedAlong, turnedInPane } from "../src/plane_turn";
import { shownPlanes, type SliceCamera } from "../src/shown_planes";
import type { Turn } from "../src/view_geometry";

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

function shown(mode: string, plane: number, planes: Turn) {
  const camera: SliceCamera = {
    ...kStraight,
    target: { x: 0, y: 0, z: 0 },
    fieldMm: 100,
    distanceMm: 80,
    sliceDepthMm: 80,
    perspective: false,
    openingDeg: 30,
    planes,
    plane,
    stepMm: 5,
  };
  return shownPlanes(mode, { width: 300, height: 300 }, camera);
}

const kRight = { x: 1, y: 0, z: 0 };
const kDeeper = { x: 0, y: 1, z: 0 };
const kSweep = { x: 0, y: 0, z: 1 };
const opposite = ({ x, y, z }: Record<Axis, number>) => ({ x: -x, y: -y, z: -z });

test("a quarter of a turn shows other directions to the right and upwards in A, B and C", () => {
  const quarters = [
    { turn: { ...kStraight, yawDeg: 90 }, rights: [kDeeper, kSweep, kDeeper], ups: [kRight, kRight, kSweep] },
    {
      turn: { ...kStraight, pitchDeg: 90 },
      rights: [kRight, kDeeper, kRight],
      ups: [kSweep, kSweep, kDeeper],
    },
    {
      turn: { ...kStraight, rollDeg: 90 },
      rights: [opposite(kSweep), kRight, opposite(kSweep)],
      ups: [opposite(kDeeper), opposite(kDeeper), kRight],
    },
  ];
  for (const { turn, rights, ups } of quarters) {
    for (const [index, plane] of shown("slices", 0, turn).entries()) {
      near(plane.right, rights[index]!, `${plane.name}, right, ${JSON.stringify(turn)}`);
      near(plane.up, ups[index]!, `${plane.name}, up, ${JSON.stringify(turn)}`);
    }
    for (const [index, right] of rights.entries()) {
      const nine = shown("tomography", index, turn);
      near(nine[4]!.right, right, `nine planes ${index}`);
      near(nine[4]!.up, ups[index]!, `nine planes ${index}`);
    }
  }
});

test("planes turn on where they look along the sweep", () => {
  const [, paneB] = panes;
  const quarter = turnedInPane(kStraight, paneB!, Math.PI / 2);
  assert.ok(Math.abs(quarter.pitchDeg - 90) < 0.01, JSON.stringify(quarter));
  const half = turnedInPane(quarter, paneB!, Math.PI / 2);
  near(alongTurned(half, "x", 1), kRight, "the pane's normal");
  near(alongTurned(half, "y", 1), opposite(kDeeper), "depth is upwards");
});

test("a line moves the target along its axis, and keeps what the picture does not show yet", () => {
  const half = Math.SQRT1_2;
  const [origin, slanted] = [
    { x: 0, y: 0, z: 0 },
    { x: half, y: half, z: 0 },
  ];
  near(movedAlong(origin, origin, slanted, 10), { x: 7.07, y: 7.07, z: 0 }, "alone");
  const aside = { x: -3, y: 3, z: 5 };
  near(movedAlong(aside, origin, slanted, 10), { x: 4.07, y: 10.07, z: 5 }, "after a move aside");
  near(movedAlong({ x: 2, y: 2, z: 0 }, origin, slanted, 10), { x: 7.07, y: 7.07, z: 0 }, "after one along it");
});
