// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { SliceClick, slicePoint } from "../src/slice_click";
import { pixelIn, planeAt, pointAt, shownPlanes, type BodyPoint, type SliceCamera } from "../src/shown_planes";

const size = { width: 800, height: 400 };
const camera: SliceCamera = {
  fieldMm: 200,
  distanceMm: 50,
  perspective: false,
  openingDeg: 90,
  target: { x: 1, y: 80, z: -5 },
  yawDeg: 0,
  pitchDeg: 0,
  rollDeg: 0,
  sliceDepthMm: 50,
  planes: { yawDeg: 0, pitchDeg: 0, rollDeg: 0 },
  plane: 0,
  stepMm: 5,
};

function near(actual: BodyPoint | undefined, expected: BodyPoint): void {
  assert.ok(actual);
  for (const axis of ["x", "y", "z"] as const)
    assert.ok(Math.abs(actual[axis] - expected[axis]) < 0.02, `${axis}: ${actual[axis]}, not ${expected[axis]}`);
}

test("the middle of each pane of the slices is the target; the fourth pane is no slice", () => {
  for (const pixel of [
    { x: 200, y: 100 },
    { x: 600, y: 100 },
    { x: 200, y: 300 },
  ])
    near(slicePoint(pixel, "slices", size, camera), camera.target);
  assert.equal(slicePoint({ x: 600, y: 300 }, "slices", size, camera), undefined);
  assert.equal(slicePoint({ x: 200, y: 100 }, "surface", size, camera), undefined);
});

test("the panes show x and depth, z and depth, and x and z; a pixel is a millimetre here", () => {
  near(slicePoint({ x: 220, y: 130 }, "slices", size, camera), { x: 21, y: 110, z: -5 });
  near(slicePoint({ x: 620, y: 130 }, "slices", size, camera), { x: 1, y: 110, z: 15 });
  near(slicePoint({ x: 220, y: 330 }, "slices", size, camera), { x: 21, y: 80, z: -35 });
});

test("a click on one of nine planes gives a point of that plane", () => {
  const nine = { width: 600, height: 300 };
  const planes = { ...camera, fieldMm: 100, stepMm: 5 }; // a pixel is a millimetre
  // The fifth plane goes through the target; the ninth lies 20 mm farther.
  near(slicePoint({ x: 300, y: 150 }, "tomography", nine, planes), camera.target);
  near(slicePoint({ x: 310, y: 170 }, "tomography", nine, planes), { x: 11, y: 100, z: -5 });
  near(slicePoint({ x: 500, y: 250 }, "tomography", nine, planes), { x: 1, y: 80, z: 15 });
  near(slicePoint({ x: 510, y: 250 }, "tomography", nine, { ...planes, plane: 1 }), { x: 21, y: 80, z: 5 });
  near(slicePoint({ x: 500, y: 240 }, "tomography", nine, { ...planes, plane: 2 }), { x: 1, y: 100, z: 5 });
  near(slicePoint({ x: 500, y: 240 }, "tomography", nine, { ...planes, plane: 3 }), { x: 1, y: 100, z: 5 });
});

test("an oblique slice lies at its depth, at a right angle to the view", () => {
  const middle = { x: 400, y: 200 };
  near(slicePoint(middle, "slice", size, camera), camera.target);
  near(slicePoint(middle, "slice", size, { ...camera, sliceDepthMm: 60 }), { x: 1, y: 90, z: -5 });
  // To the right by 40 pixels of half a millimetre, upwards by 20.
  const aside = { x: 440, y: 180 };
  near(slicePoint(aside, "slice", size, camera), { x: 21, y: 80, z: 5 });
  // From the side: the right of the picture is deeper.
  near(slicePoint(aside, "slice", size, { ...camera, yawDeg: 90 }), { x: 1, y: 100, z: 5 });
  // From above: forward is -z, and up in the picture is deeper.
  near(slicePoint(aside, "slice", size, { ...camera, pitchDeg: 90 }), { x: 21, y: 90, z: -5 });
  near(slicePoint(aside, "slice", size, { ...camera, rollDeg: 90 }), { x: 11, y: 80, z: -25 });
});

test("in perspective a deeper slice shows more of the body", () => {
  // The eye stands 100 mm before the target, so at 50 mm behind it everything is 1.5 times as far aside.
  const deeper = { ...camera, perspective: true, sliceDepthMm: 100 };
  near(slicePoint({ x: 440, y: 180 }, "slice", size, deeper), { x: 31, y: 130, z: 10 });
});

test("a plane behind the eye is not shown, so a click hits nothing", () => {
  const behind = { ...camera, perspective: true, sliceDepthMm: -51 };
  assert.equal(slicePoint({ x: 440, y: 180 }, "slice", size, behind), undefined);
});

/** What a click on this pixel of a picture of 800 x 400 sets. */
function sent(pixel: { x: number; y: number }, mode: string, movesRays: boolean): Map<string, unknown> {
  const numbers = new Map<string, number>([
    ["camera.field_mm", 200],
    ["camera.distance_mm", 50],
    ["rays.end_mm", 45],
    ["slice.depth_mm", 70],
  ]);
  const set = new Map<string, unknown>();
  const editor = {
    number: (name: string) => numbers.get(name) ?? 0,
    choice: (name: string) => (name === "mode" ? mode : "parallel"),
    set: (values: Iterable<readonly [string, unknown]>) => {
      for (const [name, value] of values) set.set(name, value);
    },
  };
  const canvas = { ...size, getBoundingClientRect: () => ({ left: 0, top: 0, ...size }) };
  const click = new SliceClick(editor as never, canvas as never, () => movesRays);
  click.clicked(pixel);
  return set;
}

test("a click moves the target, and the view plane stays where it is", () => {
  assert.deepEqual(
    [...sent({ x: 220, y: 130 }, "slices", true)],
    [
      ["camera.target_x_mm", 20],
      ["camera.target_y_mm", 30],
      ["camera.target_z_mm", 0],
      ["camera.distance_mm", 80],
    ],
  );
  assert.deepEqual([...sent({ x: 600, y: 300 }, "slices", true)], []);
});

test("an oblique slice stays where it is: its target lies in it", () => {
  const set = sent({ x: 400, y: 200 }, "slice", true);
  assert.equal(set.get("camera.target_y_mm"), 20);
  assert.equal(set.get("slice.depth_mm"), 50);
});

test("in a view of one's own the oblique slice is that of the main view", () => {
  assert.deepEqual(
    [...sent({ x: 220, y: 130 }, "slices", false).keys()],
    ["camera.target_x_mm", "camera.target_y_mm", "camera.target_z_mm", "camera.distance_mm"],
  );
  assert.deepEqual([...sent({ x: 400, y: 200 }, "slice", false)], []);
});

test("each pixel of a plane is found again at its point, and points beside it are known", () => {
  const turned = { ...camera, yawDeg: 30, pitchDeg: -20, rollDeg: 12 };
  for (const [mode, settings] of [
    ["slices", turned],
    ["tomography", { ...turned, plane: 3 }],
    ["tomography", { ...turned, plane: 1 }],
    ["slice", { ...turned, perspective: true, sliceDepthMm: 70 }],
  ] as const) {
    const planes = shownPlanes(mode, size, settings);
    assert.equal(planes.length, { slices: 3, tomography: 9, slice: 1 }[mode]);
    for (const pixel of [
      { x: 120, y: 90 },
      { x: 333, y: 61 },
    ]) {
      const plane = planeAt(pixel, planes)!;
      const { pixel: again, asideMm } = pixelIn(pointAt(pixel, plane), plane);
      assert.ok(Math.hypot(again.x - pixel.x, again.y - pixel.y) < 0.1, `${mode}: ${again.x}, ${again.y}`);
      assert.ok(asideMm < 1e-9);
    }
  }
  const [plane] = shownPlanes("slices", size, camera);
  assert.equal(pixelIn({ x: 1, y: 80, z: -2 }, plane!).asideMm, 3);
});

test("the size may be a canvas, whose width and height are no members of its own", () => {
  class Canvas {
    get width(): number {
      return size.width;
    }
    get height(): number {
      return size.height;
    }
  }
  for (const mode of ["slice", "slices", "tomography"])
    near(slicePoint({ x: 120, y: 90 }, mode, new Canvas(), camera), slicePoint({ x: 120, y: 90 }, mode, size, camera)!);
});
