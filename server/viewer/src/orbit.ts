// SPDX-License-Identifier: Apache-2.0
// Turns the camera about its target, and zooms, by pointer and keys.
import type { SceneField } from "../generated/fanlight_pb.js";
import { allowed, type Values } from "./scene";
import type { SettingsEditor } from "./settings_editor";
import { planeTurn } from "./plane_turn";
import { kAcross, kTomography, planeWay } from "./tomography";
import { bodyWay, orbited, surfacePart, tidy, type PagePoint } from "./view_geometry";

// A click on a slice, and what finds the surface, set these together with the camera.
const kRays = ["rays.start_mm", "rays.end_mm", "slice.depth_mm"];

export class Orbit {
  private field: SceneField | undefined;
  private defaults: Values = new Map();

  /** `movesRays`: whether the rays may be changed; a view of one's own has those of the main view. */
  constructor(
    private readonly editor: SettingsEditor,
    private readonly canvas: HTMLCanvasElement,
    private readonly movesRays: () => boolean,
  ) {}

  start(fields: SceneField[], defaults: Values): void {
    this.field = fields.find((field) => field.name === "camera.field_mm");
    this.defaults = new Map([...defaults].filter(([name]) => name.startsWith("camera.") || kRays.includes(name)));
  }

  /** `moved` is in pixels of the page. */
  drag(moved: PagePoint): void {
    const angles = { yawDeg: this.editor.number("camera.yaw_deg"), pitchDeg: this.editor.number("camera.pitch_deg") };
    const part = surfacePart(this.editor.choice("mode"), this.canvas) ?? this.canvas;
    const { yawDeg, pitchDeg } = orbited(angles, moved, (this.canvas.clientHeight * part.height) / this.canvas.height);
    this.editor.set([
      ["camera.yaw_deg", yawDeg],
      ["camera.pitch_deg", pitchDeg],
    ]);
  }

  /** Shifts the view: the body follows the pointer. `moved` is in pixels of the page. */
  pan(moved: PagePoint): void {
    const number = (name: string) => this.editor.number(name);
    const part = surfacePart(this.editor.choice("mode"), this.canvas);
    const isTomography = this.editor.choice("mode") === kTomography;
    const wholeHeight = this.canvas.height / (isTomography ? kAcross : 1);
    const fieldPixels = part?.fieldPixels ?? part?.height ?? wholeHeight;
    const mmPerPixel = (number("camera.field_mm") * this.canvas.height) / (fieldPixels * this.canvas.clientHeight);
    const turn = {
      yawDeg: number("camera.yaw_deg"),
      pitchDeg: number("camera.pitch_deg"),
      rollDeg: number("camera.roll_deg"),
    };
    const [right, up] = [-moved.x * mmPerPixel, moved.y * mmPerPixel];
    const turns = { view: turn, planes: planeTurn(this.editor) };
    const way = isTomography ? planeWay(number("slice.plane"), turns, right, up, 0) : bodyWay(turn, right, up, 0);
    this.editor.set([
      ["camera.target_x_mm", tidy(number("camera.target_x_mm") + way.x)],
      ["camera.target_y_mm", tidy(number("camera.target_y_mm") + way.y)],
      ["camera.target_z_mm", tidy(number("camera.target_z_mm") + way.z)],
    ]);
  }

  /** A factor above 1 shows more of the body. */
  zoom(factor: number): void {
    if (!this.field) return;
    const heightMm = tidy(this.editor.number("camera.field_mm") * factor);
    this.editor.set([["camera.field_mm", allowed(this.field, heightMm)]]);
  }

  reset(): void {
    this.editor.set([...this.defaults].filter(([name]) => this.movesRays() || !kRays.includes(name)));
  }
}
