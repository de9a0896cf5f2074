// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { ViewSchema } from "../generated/fanlight_pb.js";
import {
  ballsCut,
  cutsOf,
  cutsText,
  depthOf,
  kMostCuts,
  lassoCut,
  placesInside,
  pointAt,
  sameCuts,
  simplified,
  withCut,
} from "../src/cut_shapes";

// From the probe: right is x, down is -z, forward is y. A pixel has 0.5 mm.
const kView = create(ViewSchema, {
  matrix: [1, 0, 0, 0, 0, 0, 1, 10, 0, -1, 0, 0, 0, 0, 0, 1],
  mmPerPixel: 0.5,
  middleColumn: 100,
  middleRow: 50,
});
const kTriangle = [
  { x: 90, y: 60 },
  { x: 110, y: 60 },
  { x: 100, y: 30 },
];

test("a lasso is drawn in the view plane, in mm to the right and up", () => {
  assert.equal(
    lassoCut("inside", kTriangle, kView, 0),
    "inside -3000 3000 from 0 10 0 right 1 0 0 up 0 0 1 eye 0 outline -5 -5 5 -5 0 10",
  );
  assert.match(lassoCut("outside", kTriangle, kView, 20, 42.129), /^outside -3000 22.13 from 0 30 0 /);
  const perspective = { ...kView, mmPerPixelPerMm: 0.005 };
  assert.match(lassoCut("inside", kTriangle, perspective, 0), / eye 100 outline/);
  // The eye lies beyond the view plane; the lasso is drawn in one before it.
  const beyond = { ...kView, mmPerPixel: -0.1, mmPerPixelPerMm: 0.005 };
  assert.equal(
    lassoCut("inside", kTriangle, beyond, 60),
    "inside -3000 3000 from 0 70 0 right 1 0 0 up 0 0 1 eye 40 outline -2 -2 2 -2 0 4",
  );
});

test("texts of the same cuts are the same, however the numbers are written", () => {
  assert.ok(sameCuts("balls 6 at 1 2 3", " balls 6 at 1.0 2 0.3e1;"));
  assert.ok(sameCuts("", ""));
  assert.ok(!sameCuts("balls 6 at 1 2 3", "balls 6 at 1 2 4"));
  assert.ok(!sameCuts("balls 6 at 1 2 3", ""));
});

test("a point is seen at its pixel", () => {
  const perspective = { ...kView, mmPerPixelPerMm: 0.005 };
  const point = pointAt({ x: 110, y: 60 }, 40, perspective);
  assert.deepEqual(point, [7, 50, -7]);
  assert.equal(depthOf(point, perspective), 40);
});

test("a depth is counted from the view plane", () => {
  assert.equal(depthOf([3, 35, -2], kView), 25);
});

test("balls have a radius and centres", () => {
  assert.equal(
    ballsCut(6, [
      [1, 2.004, -3],
      [4, 5, 6],
    ]),
    "balls 6 at 1 2 -3 4 5 6",
  );
});

test("cuts are added up to what the server takes", () => {
  const ball = "balls 6 at 1 2 3";
  assert.equal(withCut("", ball), ball);
  assert.equal(withCut(ball, ball), `${ball}; ${ball}`);
  assert.deepEqual(cutsOf(`${ball}; ${ball} ;`), [ball, ball]);
  const full = Array.from({ length: kMostCuts }, () => ball).join(";");
  assert.equal(withCut(full, ball), undefined);
  const long = ballsCut(
    6,
    Array.from({ length: 511 }, () => [1, 2, 3] as const),
  );
  assert.notEqual(withCut(long, ball), undefined);
  assert.equal(withCut(`${long}; ${ball}`, ball), undefined);
});

test("the mark counts what is cut away", () => {
  assert.equal(cutsText(""), "");
  assert.equal(cutsText("balls 6 at 1 2 3"), "Cut away: 1 part");
  assert.equal(cutsText("balls 6 at 1 2 3; balls 6 at 1 2 3"), "Cut away: 2 parts");
});

test("a hand's line keeps its form with few corners", () => {
  const circle = Array.from({ length: 1000 }, (_, at) => ({
    x: 100 + 80 * Math.cos((at * Math.PI) / 500),
    y: 100 + 80 * Math.sin((at * Math.PI) / 500),
  }));
  const few = simplified(circle);
  assert.ok(few.length >= 12 && few.length <= 96, `${few.length} corners`);
  for (const { x, y } of few) assert.ok(Math.abs(Math.hypot(x - 100, y - 100) - 80) < 1e-9);
  assert.deepEqual(simplified(kTriangle), kTriangle);
});

test("places inside a lasso lie inside", () => {
  const places = placesInside(kTriangle, 100);
  assert.ok(places.length > 30 && places.length < 100, `${places.length} places`);
  assert.ok(places.every(({ x, y }) => y < 60 && y > 30 && x > 90 && x < 110));
});
