// SPDX-License-Identifier: Apache-2.0
// Lines over the four panes that move the planes, the depth scales, the handle at the end of the near tissue, and the
// crop box with handles in all panes.
import type { View } from "../generated/fanlight_pb.js";
import { drawing } from "./element";
import { PaneTitles, type TitledPlanes } from "./pane_titles";
import { pixelOfPoint } from "./measuring/surface_path";
import {
  alongAxisMm,
  barIn,
  boxNear,
  depthTicks,
  kCropFields,
  kPlaneOf,
  lineIn,
  panesOf,
  pixelAlong,
  sideText,
  valueAlong,
  withinPane,
  type Axis,
  type Pane,
  type Place,
} from "./plane_geometry";
import { alongTurned, isTurned, movedAlong, planeTurn, turnValues } from "./plane_turn";
import type { SettingsEditor } from "./settings_editor";
import { kPlane, kStep } from "./tomography";
import { turnHandle } from "./turn_handle";
import { tidy, type PagePoint } from "./view_geometry";

const kAxes: readonly Axis[] = ["x", "y", "z"];
const kOrigin: Place = { x: 0, y: 0, z: 0 };
/** What does not fit the planes as soon as they are turned. */
const kAlongProbe = ".depth, .near-end, .crop, [data-line=near-end], [data-line=crop]";
const kHeight = 512; // marks have one size whatever that of the picture: pixels in one of this height
const kLeastBoxMm = 2;
const kLeastPixelsPerMm = 0.3; // a face that looks at the viewer cannot be dragged in the 3D pane
const kOpenMm = 1000;
const kDragStartPixels = 2; // a click moves nothing
const kNearShift = "near.shift_mm";
const kMostNearShiftMm = 30; // the field's range
const kKeyStepShare = 0.01; // of the picture's height
const kLargeStep = 8;
const kArrowWays: Record<string, PagePoint> = {
  ArrowLeft: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  ArrowUp: { x: 0, y: -1 },
  ArrowDown: { x: 0, y: 1 },
};

/** `way`: from where the pointer was taken to where it is, pixels of the picture. */
export interface Drag {
  moved(way: PagePoint): void;
  /** What arrow keys do, where that is not to move by some pixels: `steps` is 1 or more. */
  keyed?(way: PagePoint, steps: number): void;
  ended?(way: PagePoint): void;
}

/** What a picture shows that has all changes of this page. */
interface Shown extends TitledPlanes {
  target: Place;
  fieldMm: number;
  nearEndMm: number | undefined;
  nearShiftMm: number;
}

export class PlaneOverlay {
  private view: View | undefined;
  private fullWidth = 0;
  private nearEndMm: number | undefined; // depth (y) where the near tissue ends, at the target
  /** Of the picture: while it lacks a change, lines and scales stay where they fit it. */
  private shown: Shown = {
    mode: "",
    target: kOrigin,
    turn: { yawDeg: 0, pitchDeg: 0, rollDeg: 0 },
    plane: 0,
    stepMm: 1,
    fieldMm: 1,
    nearEndMm: undefined,
    nearShiftMm: 0,
  };
  private readonly titles = new PaneTitles();
  private cropping = false;
  private allowed = false;
  private dragging: number | undefined; // the pointer
  private grips = 0; // that were drawn
  private focused: number | undefined; // the one that keys move, by its number

  constructor(
    private readonly svg: SVGSVGElement,
    private readonly canvas: HTMLCanvasElement,
    private readonly editor: Pick<SettingsEditor, "number" | "choice" | "set">,
    /** Whether the picture is of the editor's values. */
    private readonly isCurrent: () => boolean,
  ) {}

  /** The tool "Crop" was chosen, or left. */
  chooseCrop(chosen: boolean): void {
    this.cropping = chosen;
    this.draw();
  }

  /** Whether this display may change the planes and the box. */
  allow(may: boolean): void {
    if (may === this.allowed) return;
    this.allowed = may;
    this.draw();
  }

  /** `fullWidth`: of the picture in its full size, which the view is of. `nearEndMm`: see Picture. */
  show(view: View | undefined, fullWidth: number, nearEndMm?: number): void {
    this.nearEndMm = nearEndMm;
    this.view = view;
    this.fullWidth = fullWidth;
    this.draw();
  }

  /** Opens all sides of the crop box. */
  openBox(): void {
    this.editor.set(
      kAxes.flatMap((axis) => kCropFields[axis].map((name, high) => [name, high ? kOpenMm : -kOpenMm] as const)),
    );
  }

  /** Draws the lines and handles for the values of the editor. */
  draw(): void {
    if (this.dragging !== undefined) return; // the handle under the pointer stays the same element
    if (this.isCurrent()) this.shown = this.read();
    this.titles.show(this.shown);
    // Of the text on the screen, whatever the size of the picture.
    const pixelsPerPoint = this.canvas.width / (this.canvas.clientWidth || this.canvas.width);
    this.svg.style.setProperty("--scale-text", `${(window.innerWidth >= 2600 ? 22 : 12) * pixelsPerPoint}px`);
    this.svg.style.setProperty("--unit", String(this.canvas.height / kHeight));
    this.svg.setAttribute("viewBox", `0 0 ${this.canvas.width} ${this.canvas.height}`);
    this.grips = 0;
    const focused = this.focused;
    const panes = panesOf(this.shown.mode, this.canvas);
    // The depth, the near tissue and the crop box lie along the probe's axes.
    const alongProbe = isTurned(this.shown.turn) ? [] : panes;
    const parts = [
      ...alongProbe.flatMap((pane) => this.scaleOf(pane)),
      ...panes.flatMap((pane) => this.linesOf(pane)),
      ...alongProbe.flatMap((pane) => this.nearEndIn(pane)),
    ];
    if (this.cropping) parts.push(...alongProbe.flatMap((pane) => this.boxIn(pane)), ...this.boxInSpace());
    parts.push(...panes.flatMap((pane) => this.turnIn(pane)));
    this.svg.replaceChildren(...parts);
    this.focused = focused; // the focus returns to what replaces it
  }

  private read(): Shown {
    return {
      mode: this.editor.choice("mode"),
      target: this.wantedTarget(),
      turn: planeTurn(this.editor),
      plane: this.editor.number(kPlane),
      stepMm: this.editor.number(kStep),
      fieldMm: this.editor.number("camera.field_mm"),
      nearEndMm: this.nearEndMm,
      nearShiftMm: this.editor.number(kNearShift),
    };
  }

  /** Which the picture may not have yet. */
  private wantedTarget(): Place {
    const at = (axis: Axis) => this.editor.number(`camera.target_${axis}_mm`);
    return { x: at("x"), y: at("y"), z: at("z") };
  }

  private target(): Place {
    return this.shown.target;
  }

  private fieldMm(): number {
    return this.shown.fieldMm;
  }

  private scaleOf(pane: Pane): SVGElement[] {
    const right = pane.part.left + pane.part.width;
    return depthTicks(pane, this.target(), this.fieldMm()).flatMap(({ row, depthMm }, index) => {
      const unit = this.canvas.height / kHeight;
      const text = drawing("text", { class: "depth", x: right - 12 * unit, y: row + 4 * unit });
      text.textContent = index === 0 ? `${depthMm} mm` : String(depthMm);
      return [drawing("path", { class: "depth", d: `M${right - 9 * unit} ${row}H${right - 2 * unit}` }), text];
    });
  }

  /** In each pane, where the other two planes cut it. The plane follows when the line is let go. */
  private linesOf(pane: Pane): SVGElement[] {
    return [pane.right, pane.up.axis].flatMap((axis) => {
      const isColumn = axis === pane.right;
      const from = pixelAlong(pane, axis, 0, kOrigin, this.fieldMm());
      const at = (way: PagePoint) => withinPane(pane, isColumn, from + along(isColumn, way));
      const line = `plane plane-${kPlaneOf[axis]}`;
      const label = `Plane ${kPlaneOf[axis].toUpperCase()}`;
      return this.draggable(line, label, lineIn(pane, isColumn, from), isColumn, (element) => ({
        moved: (way) => element.setAttribute("d", lineIn(pane, isColumn, at(way))),
        ended: (way) => {
          const mm = valueAlong(pane, axis, at(way), kOrigin, this.fieldMm());
          const unit = alongTurned(this.shown.turn, axis, 1);
          const wanted = movedAlong(this.wantedTarget(), this.target(), unit, mm);
          const changed = kAxes.filter((each) => Math.abs(unit[each]) > 1e-6);
          this.editor.set(changed.map((each) => [`camera.target_${each}_mm`, wanted[each]] as const));
        },
      }));
    });
  }

  private turnIn(pane: Pane): SVGElement[] {
    if (!this.allowed) return [];
    const { handle, drag } = turnHandle(pane, planeTurn(this.editor), (turn) => {
      for (const mark of this.svg.querySelectorAll(kAlongProbe)) mark.remove();
      this.editor.set(turnValues(turn));
    });
    this.connect(handle, `Handle that turns plane ${pane.name}`, drag);
    return [handle];
  }

  /** A handle where the near tissue ends before the target, in the panes that show the depth; the line follows it. */
  private nearEndIn(pane: Pane): SVGElement[] {
    const { nearEndMm, nearShiftMm } = this.shown;
    if (nearEndMm === undefined || pane.up.axis !== "y") return [];
    // Until a picture has a new shift, the handle is where the line will be.
    const shiftMm = this.editor.number(kNearShift);
    const from = pixelAlong(pane, "y", nearEndMm + shiftMm - nearShiftMm, this.target(), this.fieldMm());
    if (withinPane(pane, false, from) !== from) return [];
    const at = (row: number) => barIn(pane, row);
    return this.draggable("near-end", "End of the near tissue", at(from), false, (element) => ({
      moved: (way) => {
        const mmPerPixel = this.fieldMm() / pane.part.height;
        const wanted = shiftMm + way.y * mmPerPixel;
        const value = Math.max(-kMostNearShiftMm, Math.min(kMostNearShiftMm, wanted));
        element.setAttribute("d", at(withinPane(pane, false, from + (value - shiftMm) / mmPerPixel)));
        this.editor.set([[kNearShift, tidy(value)]]);
      },
    }));
  }

  private boxIn(pane: Pane): SVGElement[] {
    return [pane.right, pane.up.axis].flatMap((axis) =>
      kCropFields[axis].flatMap((name) => {
        const isColumn = axis === pane.right;
        const raw = pixelAlong(pane, axis, this.editor.number(name), this.target(), this.fieldMm());
        const from = withinPane(pane, isColumn, raw);
        return this.draggable("crop", sideText(name), lineIn(pane, isColumn, from), isColumn, (element) => ({
          moved: (way) => {
            const at = withinPane(pane, isColumn, from + along(isColumn, way));
            element.setAttribute("d", lineIn(pane, isColumn, at));
            this.crop(name, axis, valueAlong(pane, axis, at, this.target(), this.fieldMm()));
          },
        }));
      }),
    );
  }

  /** Sets one side; the box keeps a thickness. */
  private crop(name: string, axis: Axis, value: number): void {
    const [low, high] = kCropFields[axis];
    const limit = this.editor.number(name === low ? high : low);
    const allowed = name === low ? Math.min(value, limit - kLeastBoxMm) : Math.max(value, limit + kLeastBoxMm);
    this.editor.set([[name, tidy(allowed)]]);
  }

  /** The edges of the box in the 3D picture, and a handle in the middle of each side that can be dragged there. */
  private boxInSpace(): SVGElement[] {
    if (["slice", "tomography", ""].includes(this.shown.mode)) return [];
    const box = boxNear(this.target(), this.fieldMm(), (name) => this.editor.number(name));
    const edges = kAxes.flatMap((axis) => {
      const [first, second] = kAxes.filter((other) => other !== axis) as [Axis, Axis];
      return [0, 1].flatMap((i) =>
        [0, 1].map((j) => {
          const corner = (side: 0 | 1): Place => {
            const place = { x: 0, y: 0, z: 0 };
            place[axis] = box[axis][side];
            place[first] = box[first][i]!;
            place[second] = box[second][j]!;
            return place;
          };
          return [this.pixelOf(corner(0)), this.pixelOf(corner(1))] as const;
        }),
      );
    });
    const d = edges.map(([from, to]) => (from && to ? `M${from.x} ${from.y}L${to.x} ${to.y}` : "")).join("");
    return [drawing("path", { class: "box", d }), ...kAxes.flatMap((axis) => this.facesAlong(axis, box))];
  }

  private facesAlong(axis: Axis, box: Record<Axis, [number, number]>): SVGElement[] {
    return kCropFields[axis].flatMap((name, side) => {
      const middle = { x: 0, y: 0, z: 0 };
      for (const each of kAxes) middle[each] = each === axis ? box[each][side]! : (box[each][0] + box[each][1]) / 2;
      const at = this.pixelOf(middle);
      const further = this.pixelOf({ ...middle, [axis]: middle[axis] + 1 });
      if (!at || !further) return [];
      const perMm = { x: further.x - at.x, y: further.y - at.y };
      if (Math.hypot(perMm.x, perMm.y) < kLeastPixelsPerMm) return [];
      const handle = drawing("circle", { class: "face", cx: at.x, cy: at.y, r: (7 * this.canvas.height) / kHeight });
      this.connect(handle, sideText(name), {
        moved: (way) => {
          const mm = alongAxisMm(way, perMm);
          handle.setAttribute("cx", String(at.x + mm * perMm.x));
          handle.setAttribute("cy", String(at.y + mm * perMm.y));
          this.crop(name, axis, middle[axis] + mm);
        },
      });
      return [handle];
    });
  }

  /** In pixels of the canvas, which may be smaller than the full size that the view is of. */
  private pixelOf({ x, y, z }: Place): PagePoint | undefined {
    const full = this.view && pixelOfPoint([x, y, z], this.view);
    const share = this.canvas.width / (this.fullWidth || this.canvas.width);
    return full && { x: full.x * share, y: full.y * share };
  }

  /** Arrow keys move what the grip moves. The focus stays on it when all are drawn again. */
  private connectKeys(grip: SVGElement, label: string, drag: Drag): void {
    const number = this.grips++;
    grip.setAttribute("tabindex", "0");
    grip.setAttribute("role", "button");
    grip.setAttribute("aria-label", `${label}: move it with the arrow keys`);
    grip.onfocus = () => (this.focused = number);
    grip.onblur = () => (this.focused = undefined);
    if (this.focused === number) queueMicrotask(() => grip.focus({ preventScroll: true }));
    grip.onkeydown = (event) => {
      const way = kArrowWays[event.key];
      if (!way) return;
      const steps = event.shiftKey ? kLargeStep : 1;
      const pixels = steps * kKeyStepShare * this.canvas.height;
      const moved = { x: way.x * pixels, y: way.y * pixels };
      if (drag.keyed) drag.keyed(way, steps);
      else drag.moved(moved);
      drag.ended?.(moved);
      this.draw();
      event.preventDefault();
      event.stopPropagation(); // the arrows move no light
    };
  }

  /** A thin line, and a wide invisible one that is easy to take. */
  private draggable(
    name: string,
    label: string,
    d: string,
    isColumn: boolean,
    drag: (line: SVGElement) => Drag,
  ): SVGElement[] {
    const line = drawing("path", { class: name, d });
    const grip = drawing("path", { class: `grip ${isColumn ? "column" : "row"}`, d });
    grip.dataset.line = name;
    this.connect(grip, label, drag(line));
    return [line, grip];
  }

  private connect(grip: SVGElement, label: string, drag: Drag): void {
    if (!this.allowed) return grip.classList.add("idle");
    this.connectKeys(grip, label, drag);
    let from: PagePoint = { x: 0, y: 0 };
    let moved = false;
    // In pixels of the picture in which the grip was drawn: the picture may have another size meanwhile.
    const { width, height } = this.canvas;
    const pixelOf = (event: PointerEvent) => {
      const shown = this.canvas.getBoundingClientRect();
      return {
        x: ((event.clientX - shown.left) * width) / shown.width,
        y: ((event.clientY - shown.top) * height) / shown.height,
      };
    };
    const way = (event: PointerEvent) => {
      const { x, y } = pixelOf(event);
      return { x: x - from.x, y: y - from.y };
    };
    grip.onpointerdown = (event) => {
      if (event.button !== 0 || this.dragging !== undefined) return;
      grip.setPointerCapture(event.pointerId);
      this.dragging = event.pointerId;
      from = pixelOf(event);
      moved = false;
      event.preventDefault();
    };
    grip.onpointermove = (event) => {
      if (this.dragging !== event.pointerId) return;
      const { x, y } = way(event);
      moved ||= Math.hypot(x, y) >= kDragStartPixels;
      if (moved) drag.moved({ x, y });
    };
    grip.onpointerup = grip.onpointercancel = (event) => {
      if (this.dragging !== event.pointerId) return;
      this.dragging = undefined;
      if (event.type === "pointerup" && moved) drag.ended?.(way(event));
      this.draw();
    };
  }
}

function along(isColumn: boolean, pixel: PagePoint): number {
  return isColumn ? pixel.x : pixel.y;
}
