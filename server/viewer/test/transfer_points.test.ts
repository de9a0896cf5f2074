// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  added,
  addedInGap,
  formatPoints,
  kMostPoints,
  moved,
  parsePoints,
  pointAt,
  recoloured,
  removed,
} from "../src/transfer_points";

const kText = "0 #591f14 0, 60 #804f41 0, 255 #ffebd1 0.3";
const points = parsePoints(kText)!;
const many = Array.from({ length: kMostPoints }, (_, index) => ({ level: index, colour: "#000000", opacity: 0 }));

test("a text is read and written back", () => {
  assert.deepEqual(points[2], { level: 255, colour: "#ffebd1", opacity: 0.3 });
  assert.equal(formatPoints(points), kText);
  assert.equal(formatPoints(parsePoints("  7   #ABCDEF  1e-05 ,9 #000000 0")!), "7 #abcdef 0.00001, 9 #000000 0");
  assert.deepEqual(parsePoints(formatPoints(many)), many);
});

test("what is no transfer function is none", () => {
  const texts = ["", "0", "0 #591f14", "0 591f14 0", "0 #591f1 0", "0 #591f14 0 0", "0 #591f14 0,", "256 #591f14 0"];
  const opacities = ["x", "NaN", "1", "-0.1"].map((opacity) => `0 #591f14 ${opacity}`);
  const levels = ["1.5 #591f14 0", "-1 #591f14 0", "5 #000000 0, 5 #000000 0", "5 #000000 0, 4 #000000 0"];
  const seventeen = formatPoints([...many, { level: 99, colour: "#000000", opacity: 0 }]);
  for (const text of [...texts, ...opacities, ...levels, seventeen]) assert.equal(parsePoints(text), undefined, text);
});

test("between points it is linear, beyond them constant", () => {
  const two = parsePoints("100 #000000 0, 200 #ff8000 0.2")!;
  assert.deepEqual(pointAt(two, 150), { level: 150, colour: "#804000", opacity: 0.1 });
  assert.deepEqual([pointAt(two, 0).opacity, pointAt(two, 255).opacity], [0, 0.2]);
  assert.deepEqual([pointAt(two, 100).colour, pointAt(two, 200).colour], ["#000000", "#ff8000"]);
});

test("a moved point stays between its neighbours and in range", () => {
  assert.deepEqual(moved(points, 1, 80.4, 0.12345)[1], { level: 80, colour: "#804f41", opacity: 0.123 });
  assert.deepEqual([moved(points, 1, -9, 0)[1]?.level, moved(points, 1, 999, 0)[1]?.level], [1, 254]);
  assert.deepEqual([moved(points, 0, -9, 0)[0]?.level, moved(points, 2, 999, 0)[2]?.level], [0, 255]);
  assert.deepEqual([moved(points, 1, 60, -1)[1]?.opacity, moved(points, 1, 60, 2)[1]?.opacity], [0, 0.999]);
  assert.equal(formatPoints(points), kText);
});

test("an added point has the colour that was there", () => {
  const more = added(points, 157.6, 0.4)!;
  assert.equal(more.index, 2);
  assert.deepEqual(more.points[2], { level: 158, colour: "#c09d89", opacity: 0.4 });
  assert.equal(more.points.length, 4);
  assert.equal(added(points, 60, 0.4), undefined);
  assert.equal(added(many, 200, 0.4), undefined);
});

test("without a place it goes to the widest gap and leaves the curve as it was", () => {
  const more = addedInGap(points)!;
  assert.equal(more.points[2]?.level, 158);
  assert.equal(more.points[2]?.opacity, Number(pointAt(points, 158).opacity.toFixed(3)));
  assert.equal(addedInGap(parsePoints("0 #000000 0")!)?.points[1]?.level, 128);
  assert.equal(addedInGap(parsePoints("255 #000000 0")!)?.points[0]?.level, 127);
});

test("a point is recoloured or removed, the last one stays", () => {
  assert.equal(recoloured(points, 1, "#123456")[1]?.colour, "#123456");
  assert.equal(formatPoints(removed(points, 1)), "0 #591f14 0, 255 #ffebd1 0.3");
  assert.equal(removed(points.slice(0, 1), 0).length, 1);
});

test("every text that is made is one that is read", () => {
  let made = points;
  for (let level = 3; level < 256; level += 13) made = added(made, level, (level % 10) / 10)?.points ?? made;
  for (let index = 0; index < made.length; ++index) made = moved(made, index, index * 37, index / 7);
  assert.equal(made.length, kMostPoints);
  assert.deepEqual(parsePoints(formatPoints(made)), made);
});
