// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { SceneFieldSchema, SceneSchema } from "../generated/fanlight_pb.js";
import { allowed, sceneOf, valuesOf, type Value } from "../src/scene";

test("values travel under their dotted names, and only those that are given", () => {
  const values = new Map<string, Value>([
    ["light.right_mm", -12.5],
    ["light.up_mm", 0],
    ["detector.window", 8],
    ["clip2.normal_x", 0.5],
    ["transfer.points", "0 #000000 0, 255 #ffffff 0.5"],
    ["mode", 1],
  ]);
  const received = fromBinary(SceneSchema, toBinary(SceneSchema, sceneOf(values)));
  assert.equal(received.light?.rightMm, -12.5);
  assert.equal(received.light?.depthMm, undefined);
  assert.equal(received.camera, undefined);
  assert.deepEqual(new Map([...valuesOf(received)].sort()), new Map([...values].sort()));
});

test("a name that the schema lacks is left out", () => {
  assert.equal(
    valuesOf(
      sceneOf(
        new Map([
          ["light.colour", 1],
          ["nonsense", 2],
        ]),
      ),
    ).size,
    0,
  );
});

test("a value is brought into range and onto a step", () => {
  const size = create(SceneFieldSchema, { minimum: 1, maximum: 31, step: 2 });
  assert.deepEqual(
    [0, 4.1, 6, 99].map((value) => allowed(size, value)),
    [1, 5, 7, 31],
  );
  const height = create(SceneFieldSchema, { minimum: 1, maximum: 2000 });
  assert.deepEqual(
    [0.2, 3.3, 4000].map((value) => allowed(height, value)),
    [1, 3.3, 2000],
  );
});
