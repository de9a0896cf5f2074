// SPDX-License-Identifier: Apache-2.0
// What is measured of points of the body, and how uncertain it is. Points are in the transducer frame, mm.

/** x, y, z in the transducer frame. */
export type Mm = readonly [number, number, number];

export type Kind = "distance" | "angle" | "ellipse" | "area" | "fluid";

export interface KindInfo {
  title: string;
  /** How many points it needs; undefined: three or more, until it is closed. */
  points: number | undefined;
  /** What to click next, by the number of points that there are. */
  hints: readonly string[];
}

export const kKinds: Readonly<Record<Kind, KindInfo>> = {
  distance: { title: "Distance", points: 2, hints: ["Click the first of two points.", "Click the second point."] },
  angle: {
    title: "Angle",
    points: 3,
    hints: ["Click a point on the first side.", "Click the vertex.", "Click a point on the other side."],
  },
  ellipse: {
    title: "Ellipse",
    points: 3,
    hints: ["Click one end of an axis.", "Click the other end of this axis.", "Click any other point of the ellipse."],
  },
  area: {
    title: "Area",
    points: undefined,
    hints: [
      "Click along an outline.",
      "Click the next point.",
      "Click the next point. The first point, or a double click, closes the outline.",
    ],
  },
  fluid: {
    title: "Fluid",
    points: 1,
    hints: ["Click inside the fluid in one of the planes, not in 3D (four panes: key 4)."],
  },
};

export interface Figure {
  name: string;
  value: number;
  unit: "mm" | "mm²" | "cm³" | "deg";
  /** One standard deviation. */
  uncertainty: number;
}

const minus = (a: Mm, b: Mm): Mm => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const plus = (a: Mm, b: Mm): Mm => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const times = (factor: number, a: Mm): Mm => [factor * a[0], factor * a[1], factor * a[2]];
const dot = (a: Mm, b: Mm): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Mm, b: Mm): Mm => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a: Mm): number => Math.hypot(...a);

export function lengthOf(path: readonly Mm[]): number {
  return path.slice(1).reduce((sum, point, index) => sum + length(minus(point, path[index]!)), 0);
}

function angleDeg([a, vertex, b]: readonly Mm[]): number {
  const [one, other] = [minus(a!, vertex!), minus(b!, vertex!)];
  return (Math.atan2(length(cross(one, other)), dot(one, other)) * 180) / Math.PI;
}

export interface Ellipse {
  centre: Mm;
  /** Half axes, at right angles to each other. */
  along: Mm;
  across: Mm;
}

/** Two ends of an axis and another point; undefined where the third point is not between the ends. */
export function ellipseOf([first, second, third]: readonly Mm[]): Ellipse | undefined {
  const centre = times(0.5, plus(first!, second!));
  const along = minus(second!, centre);
  const half = length(along);
  const out = minus(third!, centre);
  const share = half > 0 ? dot(out, along) / half ** 2 : 1;
  const aside = minus(out, times(share, along));
  if (Math.abs(share) >= 1 || length(aside) === 0) return undefined;
  return { centre, along, across: times(1 / Math.sqrt(1 - share ** 2), aside) };
}

/** Ramanujan, "Modular equations and approximations to pi", 1914: within 1e-4 up to half axes of 10 to 1. */
function circumferenceMm(ellipse: Ellipse): number {
  const [a, b] = [length(ellipse.along), length(ellipse.across)];
  const h = ((a - b) / (a + b)) ** 2;
  return Math.PI * (a + b) * (1 + (3 * h) / (10 + Math.sqrt(4 - 3 * h)));
}

/** Half of the vector area of a closed outline: its direction is at right angles to the plane that fits best. */
export function vectorArea(outline: readonly Mm[]): Mm {
  // From one of the points, so that the numbers stay small.
  const around = outline.map((point) => minus(point, outline[0]!));
  const twice = around.map((point, index) => cross(point, around[(index + 1) % around.length]!));
  return times(0.5, twice.reduce(plus, [0, 0, 0]));
}

/**
 * What follows from points that are each uncertain by `sdMm` along x, y and z: the formula's change with each of them,
 * summed as independent errors are.
 */
function figure(
  name: string,
  unit: Figure["unit"],
  points: readonly Mm[],
  sdMm: Mm,
  formula: (points: readonly Mm[]) => number,
): Figure {
  const value = formula(points);
  const step = 1e-3; // mm
  let variance = 0;
  for (const index of points.keys()) {
    for (const axis of [0, 1, 2] as const) {
      const moved = points.map((point, at) =>
        at === index ? (point.map((mm, along) => (along === axis ? mm + step : mm)) as unknown as Mm) : point,
      );
      variance += (((formula(moved) - value) / step) * sdMm[axis]) ** 2;
    }
  }
  return { name, value, unit, uncertainty: Math.sqrt(variance) };
}

/**
 * Of the points that the kind needs; none where they do not make one. `path`: of a distance, along the surface; its
 * uncertainty is that of its ends.
 */
export function figuresOf(kind: Kind, points: readonly Mm[], sdMm: Mm, path?: readonly Mm[]): Figure[] {
  const of = (name: string, unit: Figure["unit"], formula: (points: readonly Mm[]) => number) =>
    figure(name, unit, points, sdMm, formula);
  switch (kind) {
    case "distance": {
      const straight = of("straight", "mm", lengthOf);
      if (!path) return [straight];
      return [straight, { ...straight, name: "along the surface", value: lengthOf(path) }];
    }
    case "angle":
      return length(minus(points[0]!, points[1]!)) > 0 && length(minus(points[2]!, points[1]!)) > 0
        ? [of("angle", "deg", angleDeg)]
        : [];
    case "ellipse": {
      if (!ellipseOf(points)) return [];
      const by = (formula: (ellipse: Ellipse) => number) => (moved: readonly Mm[]) => {
        const ellipse = ellipseOf(moved);
        return ellipse ? formula(ellipse) : NaN;
      };
      return [
        of("circumference", "mm", by(circumferenceMm)),
        of(
          "area",
          "mm²",
          by(({ along, across }) => Math.PI * length(along) * length(across)),
        ),
        of(
          "first axis",
          "mm",
          by(({ along }) => 2 * length(along)),
        ),
        of(
          "second axis",
          "mm",
          by(({ across }) => 2 * length(across)),
        ),
      ];
    }
    case "fluid":
      return []; // the server measures it
    case "area":
      if (points.length < 3 || crossesItself(points)) return [];
      return [
        of("flat area", "mm²", (outline) => length(vectorArea(outline))),
        of("circumference", "mm", (outline) => lengthOf([...outline, outline[0]!])),
      ];
  }
}

/** Whether sides of the outline meet that are not neighbours, as seen at right angles to its plane. */
function crossesItself(outline: readonly Mm[]): boolean {
  const normal = vectorArea(outline);
  const count = outline.length;
  const side = (index: number) => [outline[index]!, outline[(index + 1) % count]!] as const;
  const turn = (a: Mm, b: Mm, c: Mm) => dot(cross(minus(b, a), minus(c, a)), normal);
  const part = ([a, b]: readonly [Mm, Mm], [c, d]: readonly [Mm, Mm]) => turn(a, b, c) * turn(a, b, d) < 0;
  for (let one = 0; one < count; ++one) {
    for (let other = one + 2; other < count; ++other) {
      const areNeighbours = one === 0 && other === count - 1;
      if (!areNeighbours && part(side(one), side(other)) && part(side(other), side(one))) return true;
    }
  }
  return length(normal) === 0;
}

/** Points of an ellipse, closed, for drawing. */
export function ellipsePoints({ centre, along, across }: Ellipse): Mm[] {
  const kPoints = 72;
  return Array.from({ length: kPoints + 1 }, (_, index) => {
    const angle = (2 * Math.PI * index) / kPoints;
    return plus(centre, plus(times(Math.cos(angle), along), times(Math.sin(angle), across)));
  });
}

/** A closed line of points that are uncertain by `sdMm` along x, y and z. */
export interface Outline {
  points: readonly Mm[];
  sdMm: Mm;
}

interface Disc {
  areaMm2: number;
  uncertaintyMm2: number;
  /** Along the direction that all outlines are at right angles to. */
  atMm: number;
}

const kParallel = Math.cos((2 * Math.PI) / 180);
const kLeastApartMm = 0.05;

/** Outlines in parallel planes, from one end to the other; undefined where they are not parallel, or fewer than three. */
function discsOf(outlines: readonly Outline[]): Disc[] | undefined {
  const areas = outlines.map(({ points }) => vectorArea(points));
  const first = areas[0];
  if (!first || outlines.length < 3) return undefined;
  const normal = times(1 / length(first), first);
  const discs = outlines.map(({ points, sdMm }, index) => ({
    areaMm2: length(areas[index]!),
    uncertaintyMm2: figuresOf("area", points, sdMm)[0]?.uncertainty ?? NaN,
    atMm: points.reduce((sum, point) => sum + dot(point, normal), 0) / points.length,
  }));
  if (areas.some((area) => Math.abs(dot(area, normal)) < kParallel * length(area))) return undefined;
  discs.sort((one, other) => one.atMm - other.atMm);
  const isApart = discs.every((disc, index) => index === 0 || disc.atMm - discs[index - 1]!.atMm >= kLeastApartMm);
  return isApart ? discs : undefined;
}

/**
 * The volume of a body that is outlined in parallel planes: each outline stands for half of the way to its neighbours,
 * and the outer ones for as much on their other side. The body ends anywhere between an outer outline and where the next
 * one would be, which is most of the uncertainty. undefined where the outlines are not of that kind.
 */
export function volumeOf(outlines: readonly Outline[]): Figure | undefined {
  const discs = discsOf(outlines);
  if (!discs) return undefined;
  const at = (index: number) => discs[index]!.atMm;
  const last = discs.length - 1;
  const thickness = discs.map((_, index) => {
    if (index === 0) return at(1) - at(0);
    if (index === last) return at(last) - at(last - 1);
    return (at(index + 1) - at(index - 1)) / 2;
  });
  const kMm3PerCm3 = 1000;
  const value = discs.reduce((sum, { areaMm2 }, index) => sum + areaMm2 * thickness[index]!, 0) / kMm3PerCm3;
  const ofEnd = (index: number) => (discs[index]!.areaMm2 * thickness[index]!) ** 2 / 12;
  // Where the area changes from one to the other is not known, but for its middle.
  const ofGap = (index: number) =>
    (((discs[index + 1]!.areaMm2 - discs[index]!.areaMm2) * (at(index + 1) - at(index))) / 2) ** 2 / 12;
  const variance = discs.reduce(
    (sum, { uncertaintyMm2 }, index) =>
      sum + (uncertaintyMm2 * thickness[index]!) ** 2 + (index < last ? ofGap(index) : 0),
    ofEnd(0) + ofEnd(last),
  );
  return { name: "volume", value, unit: "cm³", uncertainty: Math.sqrt(variance) / kMm3PerCm3 };
}

/** "12.3 ± 0.4 mm"; areas from 1 cm² on in cm². */
export function figureText({ value, uncertainty, unit }: Figure): string {
  if (uncertainty === 0) return `${value.toFixed(2)}${unit === "deg" ? "°" : ` ${unit}`}`; // a program's: none is known
  if (unit === "mm²" && value >= 100) return `${(value / 100).toFixed(2)} ± ${atLeast(uncertainty / 100, 2)} cm²`;
  if (unit === "cm³") return `${value.toFixed(2)} ± ${atLeast(uncertainty, 2)} cm³`;
  const shown = unit === "deg" ? "°" : ` ${unit}`;
  return `${value.toFixed(1)} ± ${atLeast(uncertainty, 1)}${shown}`;
}

/** Rounded up: no figure is more certain than its last digit. */
function atLeast(value: number, digits: number): string {
  const last = 10 ** -digits;
  return (Math.max(1, Math.ceil(value / last - 1e-9)) * last).toFixed(digits);
}
