// SPDX-License-Identifier: Apache-2.0
// Turns the view of one <fanlight-view> by pointer and keys. It is a private view: other displays keep theirs.
import type { Scene_Camera, ViewState } from "../../generated/fanlight_pb.js";
import type { ClientBody } from "../connection";
import { orbited, type PagePoint } from "../view_geometry";

interface Angles {
  yawDeg: number;
  pitchDeg: number;
}

const kKeyPixels = 12;
const kArrows: Record<string, PagePoint> = {
  ArrowLeft: { x: -kKeyPixels, y: 0 },
  ArrowRight: { x: kKeyPixels, y: 0 },
  ArrowUp: { x: 0, y: -kKeyPixels },
  ArrowDown: { x: 0, y: kKeyPixels },
};

export class OwnTurn {
  private enabled = false;
  private angles: Angles | undefined; // of the view on show, or asked for; undefined: not known
  private from: PagePoint | undefined; // of the drag under way
  private inFlight = false; // a change that the server has not answered; the newest of the others waits
  private isDue = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly send: (body: ClientBody) => void,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.pressed(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    for (const name of ["pointerup", "pointercancel"] as const)
      canvas.addEventListener(name, () => (this.from = undefined));
    canvas.addEventListener("keydown", (event) => this.typed(event));
  }

  enable(enabled: boolean): void {
    this.enabled = enabled;
    this.canvas.classList.toggle("turnable", enabled);
    this.canvas.tabIndex = enabled ? 0 : -1;
  }

  /** Call with the main view's camera at the start of a session, and when the private view has ended. */
  start(main: Scene_Camera | undefined): void {
    this.inFlight = this.isDue = false;
    this.from = undefined;
    this.angles = main && { yawDeg: main.yawDeg ?? 0, pitchDeg: main.pitchDeg ?? 0 };
  }

  /** The server has answered a change. */
  answered(state: ViewState | undefined): void {
    this.inFlight = false;
    const camera = state?.scene?.camera;
    if (this.isDue) return this.ask();
    if (camera && !this.from) this.angles = { yawDeg: camera.yawDeg ?? 0, pitchDeg: camera.pitchDeg ?? 0 };
  }

  private pressed(event: PointerEvent): void {
    if (!this.enabled || event.button !== 0) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({ preventScroll: true });
    this.from = { x: event.clientX, y: event.clientY };
    event.preventDefault();
  }

  private moved(event: PointerEvent): void {
    if (!this.from) return;
    const moved = { x: event.clientX - this.from.x, y: event.clientY - this.from.y };
    this.from = { x: event.clientX, y: event.clientY };
    this.turn(moved);
  }

  private typed(event: KeyboardEvent): void {
    const moved = this.enabled && !event.altKey && !event.ctrlKey && !event.metaKey ? kArrows[event.key] : undefined;
    if (!moved) return;
    this.turn(moved);
    event.preventDefault();
  }

  private turn(moved: PagePoint): void {
    if (!this.angles || this.canvas.clientHeight === 0) return;
    this.angles = orbited(this.angles, moved, this.canvas.clientHeight);
    if (this.inFlight) this.isDue = true;
    else this.ask();
  }

  private ask(): void {
    this.inFlight = true;
    this.isDue = false;
    this.send({ case: "view", value: { scene: { camera: this.angles! } } });
  }
}
