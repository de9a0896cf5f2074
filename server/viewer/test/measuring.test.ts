// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { MeasurementListSchema, MeasurementSchema, type Picture } from "../generated/fanlight_pb.js";
import type { MeasurementWish } from "../src/measuring/kept_measurements";
import { ellipseOf, ellipsePoints, figuresOf, figureText, volumeOf, type Mm } from "../src/measuring/figures";
import {
  csvOf,
  measurementLine,
  MeasurementList,
  measurementText,
  placeSdMm,
  volumeOfPicture,
  type Measurement,
} from "../src/measuring/measurement_list";

const sd = (mm: number): Mm => [mm, mm, mm];
const circle = (radiusMm: number, zMm: number, points = 60): Mm[] =>
  Array.from({ length: points }, (_, index) => {
    const angle = (2 * Math.PI * index) / points;
    return [3 + radiusMm * Math.cos(angle), 70 + radiusMm * Math.sin(angle), zMm];
  });

function near(actual: number | undefined, expected: number, within: number): void {
  assert.ok(actual !== undefined && Math.abs(actual - expected) <= within, `${actual}, not ${expected}`);
}

test("a distance is as uncertain as both of its ends, and longer along the surface", () => {
  const half = circle(10, 5, 360).slice(0, 181);
  const [straight, along] = figuresOf("distance", [half[0]!, half.at(-1)!], sd(0.2), half);
  near(straight?.value, 20, 1e-9);
  near(straight?.uncertainty, 0.2 * Math.SQRT2, 1e-4);
  near(along?.value, 10 * Math.PI, 0.01);
  assert.equal(along?.name, "along the surface");
  assert.equal(figuresOf("distance", [half[0]!, half[9]!], sd(0.2)).length, 1);
});

test("an angle is that at the second point, and uncertain where its sides are short", () => {
  const right: Mm[] = [
    [10, 0, 0],
    [0, 0, 0],
    [0, 0, 20],
  ];
  const [angle] = figuresOf("angle", right, sd(0.2));
  near(angle?.value, 90, 1e-9);
  // 1/a^2 + 1/b^2 + (c / (a b))^2, with c the third side.
  near(angle?.uncertainty, ((0.2 * Math.sqrt(1 / 100 + 1 / 400 + 500 / 40_000)) / Math.PI) * 180, 0.01);
  const straight = figuresOf(
    "angle",
    [
      [-5, 1, 2],
      [0, 1, 2],
      [9, 1, 2],
    ],
    sd(0),
  );
  near(straight[0]?.value, 180, 1e-9);
  assert.deepEqual(figuresOf("angle", [right[0]!, right[0]!, right[2]!], sd(0.2)), []);
});

test("an ellipse goes through its points, and has the area and the circumference of the textbook", () => {
  const [a, b] = [25, 15];
  const angle = 0.7;
  const points: Mm[] = [
    [-a, 60, 4],
    [a, 60, 4],
    [a * Math.cos(angle), 60, 4 - b * Math.sin(angle)],
  ];
  const [circumference, area, first, second] = figuresOf("ellipse", points, sd(0.2));
  near(first?.value, 50, 1e-9);
  near(second?.value, 30, 1e-9);
  near(area?.value, Math.PI * a * b, 1e-6);
  near(circumference?.value, 127.635, 1e-3); // 4 a E(e), by its series
  const drawn = ellipsePoints(ellipseOf(points)!);
  for (const [x, , z] of drawn) near((x / a) ** 2 + ((z - 4) / b) ** 2, 1, 1e-9);
  assert.deepEqual(
    drawn[0]!.map((mm) => Math.round(mm)),
    [25, 60, 4],
  );
  assert.deepEqual(figuresOf("ellipse", [points[0]!, points[1]!, [30, 60, 9]], sd(0.2)), [], "beyond the axis");
});

test("an outline has the area of its polygon, in any plane and in either direction", () => {
  const square: Mm[] = [
    [0, 0, 0],
    [10, 0, 0],
    [10, 8, 6],
    [0, 8, 6],
  ]; // 10 x 10, aslant
  for (const outline of [square, [...square].reverse()]) {
    const [area, around] = figuresOf("area", outline, sd(0.1));
    near(area?.value, 100, 1e-9);
    near(around?.value, 40, 1e-9);
    // Each corner moves half of a diagonal, along both axes of the plane: 0.1 sqrt(4 * 2 * 5^2).
    near(area?.uncertainty, 0.1 * Math.sqrt(200), 1e-2);
    assert.equal(area?.name, "flat area");
  }
  assert.deepEqual(figuresOf("area", square.slice(0, 2), sd(0.1)), []);
  const [a, b, c, d] = square as [Mm, Mm, Mm, Mm];
  assert.deepEqual(figuresOf("area", [a, c, b, d], sd(0.1)), [], "a bow");
  assert.deepEqual(figuresOf("area", [a, b, [20, 0, 0]], sd(0.1)), [], "points in one line");
});

test("outlines of a sphere in parallel planes have its volume, also when they are clicked in any order", () => {
  const radius = 12;
  const offsets = [-10, -6, 6, 2, -2, 10]; // 4 mm apart
  const outlineAt = (z: number) => ({ points: circle(Math.sqrt(radius ** 2 - z ** 2), z), sdMm: sd(0.2) });
  const outlines = offsets.map(outlineAt);
  const volume = volumeOf(outlines)!;
  const true_cm3 = (4 / 3) * Math.PI * 1.2 ** 3;
  near(volume.value / true_cm3, 1, 0.02);
  // Few outlines, or such that end at the rim, err by more, and say so.
  for (const few of [
    [-8, 0, 8],
    [-11, 0, 11],
  ]) {
    const { value, uncertainty } = volumeOf(few.map(outlineAt))!;
    assert.ok(Math.abs(value - true_cm3) < 2 * uncertainty, `${value} +- ${uncertainty} cm3, not ${true_cm3}`);
  }
  assert.equal(volumeOf(outlines.slice(0, 2)), undefined, "two outlines");
  const aslant = { points: circle(5, 0).map(([x, y]) => [x, y, y] as Mm), sdMm: sd(0.2) };
  assert.equal(volumeOf([...outlines, aslant]), undefined, "a plane that is not parallel");
  assert.equal(volumeOf([...outlines, outlines[0]!]), undefined, "one plane twice");
});

test("figures are written with their uncertainty, rounded up", () => {
  const figure = { name: "", value: 12.34, unit: "mm", uncertainty: 0.21 } as const;
  assert.equal(figureText(figure), "12.3 ± 0.3 mm");
  assert.equal(figureText({ ...figure, uncertainty: 0.001 }), "12.3 ± 0.1 mm");
  assert.equal(figureText({ ...figure, uncertainty: 0 }), "12.34 mm", "none is known");
  assert.equal(figureText({ ...figure, unit: "deg", value: 90, uncertainty: 1.2 }), "90.0 ± 1.2°");
  assert.equal(figureText({ ...figure, unit: "mm²", value: 99, uncertainty: 2 }), "99.0 ± 2.0 mm²");
  assert.equal(figureText({ ...figure, unit: "mm²", value: 1234, uncertainty: 21 }), "12.34 ± 0.21 cm²");
});

const pictureOf = (volume: bigint) =>
  ({ volumeId: volume, firstFrameNumber: 10n * volume, lastFrameNumber: 10n * volume + 9n }) as Picture;
const base = { place: "in plane A", of: volumeOfPicture(pictureOf(7n)), sdMm: placeSdMm([0.6, 0.6, 4], 0.3) };
const distance = {
  ...base,
  kind: "distance",
  points: [
    [0, 0, 0],
    [3, 4, 0],
  ],
} as const;

test("the list keeps what was measured, by volume, with names of the user's", () => {
  const list = new MeasurementList();
  const first = list.add(distance)!;
  list.add({ ...distance, of: volumeOfPicture(pictureOf(8n)) });
  assert.equal(
    list.add({
      ...distance,
      kind: "angle",
      points: [
        [0, 0, 0],
        [0, 0, 0],
        [1, 0, 0],
      ],
    }),
    undefined,
  );
  assert.equal(measurementText(first), "5.0 ± 0.3 mm");
  list.rename(first.id, " BPD ");
  assert.equal(measurementLine(list.all()[0]!), "BPD Distance: 5.0 ± 0.3 mm");
  list.rename(first.id, "");
  assert.equal(list.all()[0]!.name, "BPD");
  const names = (of: readonly Measurement[]) => of.map(({ name }) => name).join(" ");
  assert.equal(names(list.of(pictureOf(8n))), "2");
  for (const z of [-4, 0, 4]) list.add({ ...base, kind: "area", points: circle(5, z) });
  const volume = list.addVolume(pictureOf(7n))!;
  assert.equal(volume.place, "of the outlines 3, 4, 5");
  near(volume.figures[0]?.value, (Math.PI * 25 * 12) / 1000, 0.01);
  assert.equal(list.addVolume(pictureOf(8n)), undefined);
  assert.equal(list.addVolume(pictureOf(7n)), undefined, "these outlines are used");
  list.remove(first.id);
  assert.equal(names(list.all()), "2 3 4 5 6");
  list.startRun(99n, false); // a volume with the same number is another one
  assert.deepEqual(list.of(pictureOf(8n)), []);
  assert.equal(list.all().length, 5);
  list.clear();
  assert.deepEqual(list.all(), []);
});

test("the file has a line for each figure, and nothing that a spreadsheet computes", () => {
  const list = new MeasurementList();
  const made = list.add({
    ...distance,
    path: [
      [0, 0, 0],
      [0, 4, 0],
      [3, 4, 0],
    ],
    captured: new Date(0),
  })!;
  list.rename(made.id, '=1+1,"a"');
  const [head, straight, along, end] = csvOf(list.all()).split("\r\n");
  assert.match(head!, /^\ufeffname,kind,figure,value,unit,standard_deviation,place,volume_id,run_id,captured,points/);
  assert.equal(
    straight,
    `"'=1+1,""a""",distance,straight,5.000,mm,0.274,in plane A,7,0,1970-01-01T00:00:00.000Z,"0.00 0.00 0.00; 3.00 4.00 0.00",Not for diagnosis.,70,79`,
  );
  assert.match(along!, /along the surface,7.000,mm/);
  for (const name of ["-2+3", "-2-3", "@a", "+1"]) {
    list.rename(made.id, name);
    assert.ok(csvOf(list.all()).includes(`\r\n'${name},`), name);
  }
  assert.equal(end, "");
});

/** The list of a server that got these wishes. */
function listOf(wishes: readonly MeasurementWish[], withRecording = false) {
  const changed = wishes.flatMap(({ wish }) => (wish?.case === "add" ? [create(MeasurementSchema, wish.value)] : []));
  return create(MeasurementListSchema, { ids: changed.map(({ id }) => id), changed, withRecording });
}

test("what the server keeps comes back whole, on the volume with the same frames", () => {
  const wishes: MeasurementWish[] = [];
  const list = new MeasurementList((wish) => wishes.push(wish));
  list.startRun(5n, true);
  const made = list.add({ ...distance, across: [0, 0, 1], path: distance.points, captured: new Date(1234) })!;
  assert.equal(made.isKept, false);
  const answer = listOf(wishes, true);
  list.take(answer);
  assert.deepEqual(list.all(), [{ ...made, isKept: true }]);
  // Another start plays the recording, whose volumes have other ids there.
  const later = new MeasurementList((wish) => wishes.push(wish));
  later.startRun(6n, false);
  later.take(answer);
  const again = { ...pictureOf(7n), volumeId: 99n };
  assert.equal(later.of(again)[0]?.name, "1");
  assert.equal(later.of({ ...again, lastFrameNumber: 78n }).length, 1, "a replay ends the sweep a frame earlier");
  assert.deepEqual(later.of({ ...again, lastFrameNumber: 81n }), []);
  assert.equal(later.mayChange(later.all()[0]!), false);
  later.clear();
  assert.equal(later.all().length, 1, "a viewer removes nothing of the server's");
  assert.equal(wishes.length, 1);
});

test("measurements of this page and of other displays are one list", () => {
  const wishes: MeasurementWish[] = [];
  const list = new MeasurementList((wish) => wishes.push(wish));
  list.startRun(5n, true);
  const mine = list.add(distance)!;
  const other = new MeasurementList((wish) => wishes.push(wish));
  other.startRun(5n, true);
  other.add({ ...distance, of: volumeOfPicture(pictureOf(8n)) });
  list.take(listOf(wishes));
  assert.deepEqual(
    list.all().map(({ isKept }) => isKept),
    [true, true],
  );
  assert.equal(list.add(distance)!.name, "2", "the next number");
  list.remove(list.all()[0]!.id);
  assert.deepEqual(wishes.at(-1), { wish: { case: "remove", value: mine.id } });
  // The list of before the removal brings nothing back.
  list.take(create(MeasurementListSchema, { ids: listOf(wishes.slice(0, 2)).ids }));
  assert.ok(!list.all().some(({ id }) => id === mine.id));
  list.take(create(MeasurementListSchema, {}));
  assert.equal(list.all().length, 1, "what the server has not taken yet stays");
  list.startRun(6n, true);
  assert.deepEqual(list.of(pictureOf(7n)), []);
});

test("a name and a removal reach the server before its answer, and after it", () => {
  const wishes: MeasurementWish[] = [];
  const list = new MeasurementList((wish) => wishes.push(wish));
  list.startRun(5n, true);
  const { id } = list.add(distance)!;
  list.rename(id, "BPD");
  assert.deepEqual(wishes.at(-1), { wish: { case: "rename", value: { id, name: "BPD" } } });
  list.take(listOf(wishes));
  list.rename(id, "HC");
  assert.deepEqual(wishes.at(-1), { wish: { case: "rename", value: { id, name: "HC" } } });
  list.remove(id);
  assert.deepEqual(wishes.at(-1), { wish: { case: "remove", value: id } });
  list.add(distance);
  list.clear();
  assert.deepEqual(wishes.at(-1), { wish: { case: "removeAll", value: true } });
});

test("what was measured without a connection is sent with the next session", () => {
  const wishes: MeasurementWish[] = [];
  let isConnected = true;
  const list = new MeasurementList((wish) => isConnected && wishes.push(wish));
  list.startRun(5n, true);
  list.take(listOf([]));
  isConnected = false;
  const made = list.add({ ...distance, path: Array.from({ length: 512 }, (_, z): Mm => [0, 70, z]) })!;
  isConnected = true;
  list.startRun(5n, true);
  list.take(listOf([]));
  assert.equal(wishes.length, 1);
  list.take(listOf(wishes));
  assert.equal(wishes.length, 1, "once");
  assert.deepEqual(
    list.all().map(({ id, isKept, path }) => [id, isKept, path!.length < 110, path!.at(-1)]),
    [[made.id, true, true, [0, 70, 511]]],
  );
});

test("outlines of another display make no volume with those of this page", () => {
  const wishes: MeasurementWish[] = [];
  const [list, other] = [0, 1].map(() => new MeasurementList((wish) => wishes.push(wish))) as [
    MeasurementList,
    MeasurementList,
  ];
  for (const each of [list, other]) each.startRun(5n, true);
  for (const z of [-4, 0, 4]) {
    list.add({ ...base, kind: "area", points: circle(5, z) });
    other.add({ ...base, kind: "area", points: circle(9, z) });
  }
  list.take(listOf(wishes));
  assert.equal(list.all().length, 6);
  near(list.addVolume(pictureOf(7n))!.figures[0]?.value, (Math.PI * 25 * 12) / 1000, 0.01);
  const later = new MeasurementList();
  later.startRun(5n, true);
  later.take(listOf(wishes.slice(0, 6)));
  assert.equal(later.outlinesOf(pictureOf(7n)).length, 6, "a page that has made none takes all");
});
