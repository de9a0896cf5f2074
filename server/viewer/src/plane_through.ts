// SPDX-License-Identifier: Apache-2.0
// The single plane ("slice") through two points of the body.
import type { Mm } from "./measuring/figures";
import { tidy, type Turn } from "./view_geometry";

const kShowsDepth = 0.2; // of the depth's direction that lies in the plane: with less, depth is not upright

const dot = (a: Mm, b: Mm): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const times = (factor: number, a: Mm): Mm => [factor * a[0], factor * a[1], factor * a[2]];
const plus = (a: Mm, b: Mm): Mm => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const unit = (a: Mm): Mm => times(1 / Math.hypot(...a), a);
const cross = (a: Mm, b: Mm): Mm => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

export interface PlaneView extends Turn {
  /** In the middle between the points. */
  target: Mm;
}

/**
 * The plane that holds both points and the direction `across`; undefined where these are in one line. Depth points
 * downwards where the plane shows it, and the first point is to the left of the second one.
 */
export function planeThrough(first: Mm, second: Mm, across: Mm): PlaneView | undefined {
  const way = plus(second, times(-1, first));
  const aside = plus(across, times(-dot(across, way) / (dot(way, way) || 1), way));
  if (Math.hypot(...way) === 0 || Math.hypot(...aside) < 1e-6) return undefined;
  const [one, other] = [unit(way), unit(aside)];
  const depth = plus(times(one[1], one), times(other[1], other)); // of (0, 1, 0), what lies in the plane
  const up = Math.hypot(...depth) > kShowsDepth ? times(-1, unit(depth)) : other;
  const normal = cross(one, other);
  const isLeftToRight = dot(cross(normal, up), one) >= 0;
  return { target: times(0.5, plus(first, second)), ...turnOf(times(isLeftToRight ? 1 : -1, normal), up) };
}

/** The inverse of bodyWay(): the turn of a view with these directions, which have length 1 and are at right angles. */
export function turnOf(forward: Mm, up: Mm): Turn {
  const pitch = -Math.asin(Math.min(1, Math.max(-1, forward[2])));
  const yaw = Math.atan2(-forward[0], forward[1]);
  const level: Mm = [Math.cos(yaw), Math.sin(yaw), 0];
  const upright: Mm = [-Math.sin(yaw) * Math.sin(pitch), Math.cos(yaw) * Math.sin(pitch), Math.cos(pitch)];
  const degrees = (rad: number) => tidy((rad * 180) / Math.PI);
  return {
    yawDeg: degrees(yaw),
    pitchDeg: degrees(pitch),
    rollDeg: degrees(Math.atan2(dot(up, level), dot(up, upright))),
  };
}
