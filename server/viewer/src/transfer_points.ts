// SPDX-License-Identifier: Apache-2.0
// The points of a transfer function as proto/model/transfer_function.hpp writes them: "LEVEL #RRGGBB OPACITY, ...".
// The server validates texts. This code reads texts that the server accepted, and creates valid texts only.

export interface TransferPoint {
  level: number; // grey level, whole, 0 to kMostLevel, rising from point to point
  colour: string; // #rrggbb
  opacity: number; // per mm, 0 to kMostOpacity
}

export const kMostPoints = 16;
export const kMostLevel = 255;
export const kMostOpacity = 0.999;

const kPoint = /^ *(\d{1,3}) +#([0-9a-f]{6}) +(\S+) *$/i;

/** undefined if the text is invalid. */
export function parsePoints(text: string): TransferPoint[] | undefined {
  const points: TransferPoint[] = [];
  for (const part of text.split(",")) {
    const [, level, colour, opacity] = kPoint.exec(part) ?? [];
    if (level === undefined || colour === undefined || opacity === undefined) return undefined;
    const point = { level: Number(level), colour: `#${colour.toLowerCase()}`, opacity: Number(opacity) };
    const rises = point.level > (points.at(-1)?.level ?? -1);
    if (!rises || point.level > kMostLevel || !(point.opacity >= 0 && point.opacity <= kMostOpacity)) return undefined;
    points.push(point);
  }
  return points.length <= kMostPoints ? points : undefined;
}

export function formatPoints(points: readonly TransferPoint[]): string {
  return points.map(({ level, colour, opacity }) => `${level} ${colour} ${opacity}`).join(", ");
}

/** Colour and opacity at a level: linear between points, constant beyond them. */
export function pointAt(points: readonly TransferPoint[], level: number): TransferPoint {
  const low = points.filter((point) => point.level <= level).at(-1) ?? points[0]!;
  const high = points.find((point) => point.level >= level) ?? low;
  const share = high.level > low.level ? (level - low.level) / (high.level - low.level) : 0;
  const colour = channels(low.colour).map((from, index) => from + share * (channels(high.colour)[index]! - from));
  return { level, colour: hex(colour), opacity: low.opacity + share * (high.opacity - low.opacity) };
}

/** Moves a point as far towards the target as its neighbours permit. */
export function moved(
  points: readonly TransferPoint[],
  index: number,
  level: number,
  opacity: number,
): TransferPoint[] {
  const lowest = index > 0 ? points[index - 1]!.level + 1 : 0;
  const highest = index + 1 < points.length ? points[index + 1]!.level - 1 : kMostLevel;
  const place = {
    level: Math.min(highest, Math.max(lowest, Math.round(level))),
    opacity: Math.min(kMostOpacity, Math.max(0, Number(opacity.toFixed(3)))),
  };
  return points.map((point, at) => (at === index ? { ...point, ...place } : point));
}

export function recoloured(points: readonly TransferPoint[], index: number, colour: string): TransferPoint[] {
  return points.map((point, at) => (at === index ? { ...point, colour } : point));
}

/** Adds a point with the colour of the curve there; undefined if the level has a point or all points are in use. */
export function added(
  points: readonly TransferPoint[],
  level: number,
  opacity: number,
): { points: TransferPoint[]; index: number } | undefined {
  const whole = Math.min(kMostLevel, Math.max(0, Math.round(level)));
  if (points.length >= kMostPoints || points.some((point) => point.level === whole)) return undefined;
  const index = points.filter((point) => point.level < whole).length;
  const more = [...points.slice(0, index), pointAt(points, whole), ...points.slice(index)];
  return { points: moved(more, index, whole, opacity), index };
}

/** Adds a point on the curve in the middle of the widest gap. */
export function addedInGap(points: readonly TransferPoint[]): { points: TransferPoint[]; index: number } | undefined {
  const levels = [-1, ...points.map((point) => point.level), kMostLevel + 1];
  const gaps = levels.slice(1).map((level, index) => ({ from: levels[index]!, width: level - levels[index]! }));
  const widest = gaps.reduce((best, gap) => (gap.width > best.width ? gap : best));
  const middle = Math.round(widest.from + widest.width / 2);
  return added(points, middle, pointAt(points, middle).opacity);
}

/** Removes a point; the last one cannot be removed. */
export function removed(points: readonly TransferPoint[], index: number): TransferPoint[] {
  return points.length > 1 ? points.filter((_, at) => at !== index) : [...points];
}

function channels(colour: string): number[] {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

function hex(levels: readonly number[]): string {
  return `#${levels.map((level) => Math.round(level).toString(16).padStart(2, "0")).join("")}`;
}
