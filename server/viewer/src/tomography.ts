// SPDX-License-Identifier: Apache-2.0
// Nine parallel planes: where each lies, and the controls for their direction and distance.
import { find } from "./element";
import type { Direction } from "./picture_marks";
import { isTurned } from "./plane_turn";
import type { SettingsEditor } from "./settings_editor";
import { bodyWay, type Turn } from "./view_geometry";

export const kTomography = "tomography";
export const kAcross = 3;
const kMiddle = 4;
export const [kPlane, kStep] = ["slice.plane", "slice.step_mm"];
const kTitles = ["A", "B", "C", "As seen"];

/** Whether nine planes of this direction are parallel to the picture, and not to A, B or C. */
export function followsCamera(plane: number): boolean {
  return plane === kTitles.indexOf("As seen");
}

/** How far the pane's plane is from the target, mm; panes are numbered along the rows. */
export function offsetMm(pane: number, stepMm: number): number {
  return Math.round(1000 * (pane - kMiddle) * stepMm) / 1000;
}

/** "C +10 mm", "C (turned) +10 mm". */
export function paneTitle(plane: number, pane: number, stepMm: number, turn: Turn): string {
  const offset = offsetMm(pane, stepMm);
  const sign = offset > 0 ? "+" : offset < 0 ? "\u2212" : "";
  const turned = !followsCamera(plane) && isTurned(turn) ? " (turned)" : "";
  return `${kTitles[plane] ?? ""}${turned} ${sign}${Math.abs(offset)} mm`;
}

/** In the transducer frame, mm. */
interface Way {
  x: number;
  y: number;
  z: number;
}

/** Turns of the camera, and of the planes A, B and C. */
export interface Turns {
  view: Turn;
  planes: Turn;
}

/** The way in the transducer frame, mm, of a way in such a plane, and away from it to the next ones. */
export function planeWay(plane: number, { view, planes }: Turns, right: number, up: number, away: number): Way {
  const way = [
    { x: right, y: -up, z: away },
    { x: away, y: -up, z: right },
    { x: right, y: away, z: up },
  ][plane];
  return way ? bodyWay(planes, way.x, way.z, way.y) : bodyWay(view, right, up, away);
}

/** Where the probe's directions point in planes that do not follow the camera; undefined for those that do. */
export function planeDirections(plane: number, turns: Turns): Direction[] | undefined {
  if (followsCamera(plane)) return undefined;
  const right = planeWay(plane, turns, 1, 0, 0);
  const up = planeWay(plane, turns, 0, 1, 0);
  const away = planeWay(plane, turns, 0, 0, 1);
  return (["side", "depth", "sweep"] as const).map((name) => {
    const axis = ({ side: "x", depth: "y", sweep: "z" } as const)[name];
    return { name, right: right[axis], down: -up[axis], away: away[axis] };
  });
}

export class Tomography {
  private readonly root = find("#tomography", HTMLFieldSetElement);
  private readonly plane = find("#tomography-plane", HTMLSelectElement);
  private readonly step = find("#tomography-step", HTMLSelectElement);

  constructor(private readonly editor: Pick<SettingsEditor, "set" | "number" | "choice">) {
    this.plane.onchange = () => this.editor.set([[kPlane, Number(this.plane.value)]]);
    this.step.onchange = () => this.editor.set([[kStep, Number(this.step.value)]]);
  }

  /** Whether this display may change the planes. */
  allow(may: boolean): void {
    this.root.disabled = !may;
  }

  /** After a change of the scene. */
  refresh(): void {
    const shows = this.editor.choice("mode") === kTomography;
    this.root.hidden = !shows;
    if (!shows) return;
    this.plane.value = String(this.editor.number(kPlane));
    this.step.value = String(this.editor.number(kStep)); // empty where it is none of those
  }
}
