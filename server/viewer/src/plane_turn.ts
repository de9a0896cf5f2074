// SPDX-License-Identifier: Apache-2.0
// The turn of the planes A, B and C about the target (slice.yaw_deg, pitch_deg, roll_deg), and how a hand changes it.
import type { Axis, Pane, Place } from "./plane_geometry";
import { turnOf } from "./plane_through";
import { bodyWay, tidy, type PagePoint, type Turn } from "./view_geometry";

const kFields = ["slice.yaw_deg", "slice.pitch_deg", "slice.roll_deg"] as const;
const kAxes: readonly Axis[] = ["x", "y", "z"];
const kLeastDeg = 0.005;

export function planeTurn(editor: { number(name: string): number }): Turn {
  const [yawDeg, pitchDeg, rollDeg] = kFields.map((name) => editor.number(name) || 0);
  return { yawDeg: yawDeg!, pitchDeg: pitchDeg!, rollDeg: rollDeg! };
}

export function turnValues({ yawDeg, pitchDeg, rollDeg }: Turn): [string, number][] {
  return [yawDeg, pitchDeg, rollDeg].map((value, index) => [kFields[index]!, value]);
}

export function isTurned({ yawDeg, pitchDeg, rollDeg }: Turn): boolean {
  return [yawDeg, pitchDeg, rollDeg].some((value) => Math.abs(value) > kLeastDeg);
}

/** The way in the transducer frame, mm, of one along an axis of the turned planes. */
export function alongTurned(turn: Turn, axis: Axis, mm: number): Place {
  const along = (each: Axis) => (each === axis ? mm : 0);
  return bodyWay(turn, along("x"), along("z"), along("y"));
}

/**
 * A target that lies `mm` from the one shown along a direction of length 1, and otherwise stays where it is now: a change
 * that the picture does not show yet is kept.
 */
export function movedAlong(now: Place, shown: Place, unit: Place, mm: number): Place {
  const already = kAxes.reduce((sum, axis) => sum + (now[axis] - shown[axis]) * unit[axis], 0);
  const at = (axis: Axis) => tidy(now[axis] + (mm - already) * unit[axis]);
  return { x: at("x"), y: at("y"), z: at("z") };
}

/** Planes of which the picture in a pane was turned by an angle, counterclockwise as seen. */
export function turnedInPane(turn: Turn, pane: Pick<Pane, "right" | "up">, rad: number): Turn {
  // The axes turn the other way.
  const [cos, sin] = [Math.cos(rad), -Math.sin(rad)];
  const upSign = pane.up.sign;
  const axisAfter = (axis: Axis): [number, number, number] => {
    const at = { x: 0, y: 0, z: 0 };
    if (axis === pane.right) {
      at[pane.right] = cos;
      at[pane.up.axis] = sin * upSign;
    } else if (axis === pane.up.axis) {
      at[pane.right] = -sin * upSign;
      at[pane.up.axis] = cos;
    } else {
      at[axis] = 1;
    }
    const { x, y, z } = bodyWay(turn, at.x, at.z, at.y);
    return [x, y, z];
  };
  return turnOf(axisAfter("y"), axisAfter("z"));
}

/** The angle by which a point was moved about a middle, counterclockwise as seen, rad. */
export function angleAbout(middle: PagePoint, from: PagePoint, to: PagePoint): number {
  const angle = ({ x, y }: PagePoint) => Math.atan2(middle.y - y, x - middle.x);
  return angle(to) - angle(from);
}
