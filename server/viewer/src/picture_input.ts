// SPDX-License-Identifier: Apache-2.0
// Maps mouse, pen, touch and keys over the picture to movements of the light and the camera.
import { KeyCursor } from "./key_cursor";
import type { LightHandles } from "./light_handles";
import type { Orbit } from "./orbit";
import type { Tool } from "./tools";
import type { PagePoint } from "./view_geometry";

const kDragStartPixels = 3; // a shorter movement is a click, or half of a double click
const kZoomPerNotch = 1.1;
const kNotchPixels = 100;
const kKeyOrbitPixels = 12;
const kLongPressMs = 500;
/** Tools that need a place. */
const kPlaceTools: readonly Tool[] = ["measure", "note", "cut"];

/** A tool that draws over the picture. Points are of the page. */
export interface Strokes {
  begin(pointer: PagePoint): void;
  move(pointer: PagePoint): void;
  end(): void;
  /** Gives up what was begun, also by clicks. */
  cancel(): void;
}

export class PictureInput {
  private readonly pointers = new Map<number, PagePoint>();
  private dragged: { tool: Tool; from: PagePoint; begun: boolean } | undefined;
  private longPress = 0;
  private readonly cursor: KeyCursor;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    frame: HTMLElement,
    private readonly tool: () => Tool,
    private readonly light: LightHandles,
    private readonly orbit: Orbit,
    private readonly clicked: (pointer: PagePoint) => void,
    private readonly doubleClicked: (pointer: PagePoint) => void,
    private readonly cut?: Strokes,
  ) {
    this.cursor = new KeyCursor(frame, clicked);
    canvas.addEventListener("blur", () => this.cursor.hide());
    canvas.addEventListener("pointerdown", (event) => this.pressed(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("pointerup", (event) => this.released(event));
    canvas.addEventListener("pointercancel", (event) => this.released(event));
    canvas.addEventListener("wheel", (event) => this.rolled(event), { passive: false });
    canvas.addEventListener("dblclick", (event) => this.doubleClicked(pointOf(event)));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("keydown", (event) => this.typed(event));
  }

  private pressed(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    this.cursor.hide();
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, pointOf(event));
    if (this.pointers.size > 1) this.cut?.cancel();
    this.dragged =
      this.pointers.size > 1 ? undefined : { tool: this.toolOf(event), from: pointOf(event), begun: false };
    if (this.dragged?.tool === "light") this.light.chooseAt(this.dragged.from);
    window.clearTimeout(this.longPress);
    if (event.pointerType === "touch" && this.dragged)
      this.longPress = window.setTimeout(() => this.grab(), kLongPressMs);
    event.preventDefault();
  }

  private toolOf(event: PointerEvent): Tool {
    if (event.button === 1) return "pan";
    return event.button === 2 || event.altKey ? "orbit" : this.tool();
  }

  /** A long press takes the light, whatever tool is chosen. */
  private grab(): void {
    if (!this.dragged || this.dragged.begun) return;
    this.dragged = { ...this.dragged, tool: "light", begun: true };
    this.light.chooseAt(this.dragged.from);
    this.light.moveTo(this.dragged.from);
    navigator.vibrate?.(20);
  }

  private moved(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = pointOf(event);
    if (this.pointers.size > 1) {
      this.pinched(event.pointerId, before, now);
    } else if (this.dragged) {
      const { tool, from, begun } = this.dragged;
      this.dragged.begun ||= distance(from, now) >= kDragStartPixels;
      if (!this.dragged.begun) return;
      if (tool === "cut" && !begun) this.cut?.begin(from);
      this.dragBy(this.dragged.tool, before, now);
    }
    this.pointers.set(event.pointerId, now);
  }

  private dragBy(tool: Tool, before: PagePoint, now: PagePoint): void {
    if (tool === "light") this.light.moveTo(now);
    if (tool === "orbit") this.orbit.drag(difference(now, before));
    if (tool === "pan") this.orbit.pan(difference(now, before));
    if (tool === "cut") this.cut?.move(now);
  }

  private released(event: PointerEvent): void {
    window.clearTimeout(this.longPress);
    this.pointers.delete(event.pointerId);
    if (event.type === "pointerup" && event.button === 0 && this.dragged?.begun === false) this.clicked(pointOf(event));
    if (this.dragged?.begun && this.dragged.tool === "cut") this.cut?.[event.type === "pointerup" ? "end" : "cancel"]();
    if (this.pointers.size === 0) this.dragged = undefined;
  }

  /** Two fingers: each contributes half of the rotation; a changed distance zooms. */
  private pinched(id: number, before: PagePoint, now: PagePoint): void {
    const other = [...this.pointers].find(([candidate]) => candidate !== id)?.[1];
    if (!other) return;
    const step = difference(now, before);
    this.orbit.drag({ x: step.x / 2, y: step.y / 2 });
    const apart = distance(now, other);
    if (apart > 0) this.orbit.zoom(distance(before, other) / apart);
  }

  private rolled(event: WheelEvent): void {
    event.preventDefault();
    // With Shift held, browsers report a vertical wheel as a horizontal one.
    const pixels = (event.deltaY || event.deltaX) * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : 33);
    const notches = pixels / kNotchPixels;
    if (event.shiftKey) this.light.deepen(notches);
    else this.orbit.zoom(kZoomPerNotch ** notches);
  }

  private typed(event: KeyboardEvent): void {
    const act = this.keys(event.shiftKey)[event.key];
    if (!act || event.ctrlKey || event.metaKey) return;
    act();
    event.preventDefault();
  }

  private keys(isShifted: boolean): Record<string, () => void> {
    const takesPlaces = kPlaceTools.includes(this.tool());
    if (!takesPlaces) this.cursor.hide();
    const step = (right: number, up: number) => () => {
      if (takesPlaces) return this.cursor.move(right, up, isShifted);
      const moved = { x: right * kKeyOrbitPixels, y: -up * kKeyOrbitPixels };
      if (this.tool() === "light") this.light.nudge(right, up);
      else if (this.tool() === "pan") this.orbit.pan(moved);
      else this.orbit.drag(moved);
    };
    return {
      ArrowLeft: step(-1, 0),
      ArrowRight: step(1, 0),
      ArrowUp: step(0, 1),
      ArrowDown: step(0, -1),
      PageUp: () => this.light.deepen(-1),
      PageDown: () => this.light.deepen(1),
      "+": () => this.orbit.zoom(1 / kZoomPerNotch),
      "-": () => this.orbit.zoom(kZoomPerNotch),
      Home: () => this.orbit.reset(),
      ...(takesPlaces ? { Enter: () => this.cursor.click() } : {}),
      ...(["cut", "measure"].includes(this.tool()) ? { Escape: () => this.cut?.cancel() } : {}),
    };
  }
}

function pointOf(event: MouseEvent): PagePoint {
  return { x: event.clientX, y: event.clientY };
}

function difference(a: PagePoint, b: PagePoint): PagePoint {
  return { x: a.x - b.x, y: a.y - b.y };
}

function distance(a: PagePoint, b: PagePoint): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
