// SPDX-License-Identifier: Apache-2.0
// The scalpel: a lasso or a ball over the picture cuts away what it covers, in the body, for every display.
import type { View } from "../generated/fanlight_pb.js";
import { ballsCut, cutsOf, depthOf, lassoCut, placesInside, withCut, type LassoKind } from "./cut_shapes";
import { drawing, find } from "./element";
import type { Mm } from "./measurement";
import { page } from "./page";
import type { SettingsEditor } from "./settings_editor";
import { picturePixel, surfacePart, type PagePoint, type Size } from "./view_geometry";

const kField = "cuts.shapes";
const kApartPixels = 3; // of the page, between points of a lasso
const kClosePixels = 14; // a corner so near to the first or the last one closes the lasso
const kLeastLassoPixels = 6;
const kBallsApart = 0.5; // of a radius
const kLassoHint = "Drag around what to cut away, or click its corners and then the first one again.";
const kBallHint = "Drag over what to cut away.";

export interface ScalpelEvents {
  /** The view of what is drawn. */
  view(): View | undefined;
  /** The size in which its pixels are counted. */
  fullSize(): Size;
  /** The points of the body at these pixels; undefined where there is no surface. */
  surfaceAt(pixels: PagePoint[]): Promise<(Mm | undefined)[]>;
  /** Whether this display has turned the picture, so that its surface is not known. */
  isPreview(): boolean;
  say(sentence: string): void;
  failed(sentence: string): void;
}

/** "Cut away: 3 parts"; empty: nothing is. */
export function cutsText(shapes: string): string {
  const { length } = cutsOf(shapes);
  return length === 0 ? "" : `Cut away: ${length} ${length === 1 ? "part" : "parts"}`;
}

export class Scalpel {
  private readonly root = find("#scalpel", HTMLFieldSetElement);
  private readonly shape = find("#cut-shape", HTMLSelectElement);
  private readonly depth = find("#cut-depth", HTMLSelectElement);
  private readonly radius = find("#cut-radius", HTMLSelectElement);
  private readonly restore = find("#restore-all", HTMLButtonElement);
  private readonly mark = find("#cut-mark", HTMLElement);
  private readonly drawn = find("#lasso", SVGSVGElement);
  private chosen = false;
  private allowed = false;
  private line: PagePoint[] = []; // of the page: a lasso that is drawn or clicked
  private dragging = false;
  private stroke: { base: string; centres: Mm[]; last: PagePoint } | undefined; // of balls

  constructor(
    private readonly editor: SettingsEditor,
    private readonly events: ScalpelEvents,
  ) {
    this.shape.onchange = () => this.offer();
    this.restore.onclick = () => this.editor.set([[kField, ""]]);
    this.offer();
  }

  /** The tool was chosen, or left. */
  choose(chosen: boolean): void {
    this.chosen = chosen;
    this.cancel();
    this.refresh();
    if (chosen) this.offer();
  }

  /** Whether this display may cut. */
  allow(allowed: boolean): void {
    this.allowed = allowed;
    this.root.disabled = !allowed;
    this.refresh();
  }

  /** The scene has changed. */
  refresh(): void {
    const text = cutsText(this.editor.text(kField));
    this.root.hidden = !this.chosen;
    this.restore.hidden = text === "";
    this.mark.textContent = text;
    this.mark.hidden = text === "";
  }

  begin(pointer: PagePoint): void {
    if (!this.may(pointer)) return;
    this.line = [];
    this.dragging = true;
    this.move(pointer);
  }

  move(pointer: PagePoint): void {
    if (!this.dragging) return;
    if (this.isBall) return void this.erase(pointer);
    const last = this.line.at(-1);
    if (last && distance(last, pointer) < kApartPixels) return;
    this.line.push(pointer);
    this.draw();
  }

  end(): void {
    if (!this.dragging) return;
    this.dragging = false;
    this.stroke = undefined;
    if (!this.isBall) this.close();
  }

  cancel(): void {
    this.dragging = false;
    this.stroke = undefined;
    this.line = [];
    this.draw();
  }

  /** A click, or Enter at the cross that keys move: a ball, or a corner of a lasso. */
  clicked(pointer: PagePoint): void {
    if (!this.may(pointer)) return;
    if (this.isBall) {
      void this.erase(pointer).then(() => (this.stroke = undefined));
      return;
    }
    const [first, last] = [this.line[0], this.line.at(-1)];
    const closes = [first, last].some((corner) => corner && distance(corner, pointer) < kClosePixels);
    if (this.line.length >= 3 && closes) return this.close();
    this.line.push(pointer);
    this.draw();
  }

  private get isBall(): boolean {
    return this.shape.value === "ball";
  }

  private offer(): void {
    this.depth.hidden = this.shape.value !== "inside";
    this.radius.hidden = !this.isBall;
    if (this.chosen) this.events.say(this.isBall ? kBallHint : kLassoHint);
    this.cancel();
  }

  private may(pointer: PagePoint): boolean {
    const sentence = this.refusal(pointer);
    if (sentence !== "") this.events.failed(sentence);
    return sentence === "";
  }

  private refusal(pointer: PagePoint): string {
    if (!this.allowed) return "Only the display in control cuts, and in no view of its own.";
    const part = surfacePart(this.editor.choice("mode"), page.canvas);
    const { x, y } = picturePixel(pointer, page.canvas);
    const isIn = part && x >= part.left && y >= part.top && x < part.left + part.width && y < part.top + part.height;
    if (!isIn) return "Cut in the 3D picture: the planes show where a cut ends.";
    if (this.needsSurface && this.events.isPreview()) return "This is a preview: wait for the picture of the server.";
    return "";
  }

  private get needsSurface(): boolean {
    return this.isBall || (this.shape.value === "inside" && Number(this.depth.value) > 0);
  }

  /** In pixels of the view. */
  private pixelOf(pointer: PagePoint): PagePoint {
    const full = this.events.fullSize();
    const { x, y } = picturePixel(pointer, page.canvas);
    return { x: (x * full.width) / page.canvas.width - 0.5, y: (y * full.height) / page.canvas.height - 0.5 };
  }

  private close(): void {
    const pixels = this.line.map((pointer) => this.pixelOf(pointer));
    const view = this.events.view();
    const isTooSmall = this.line.length < 3 || extent(this.line) < kLeastLassoPixels;
    this.line = [];
    this.draw();
    if (isTooSmall || view?.matrix.length !== 16) return;
    const kind = this.shape.value as LassoKind;
    const deepMm = kind === "inside" ? Number(this.depth.value) : 0;
    if (deepMm === 0) return this.add(this.editor.text(kField), lassoCut(kind, pixels, view));
    const places = placesInside(pixels).map(({ x, y }) => ({ x: Math.round(x), y: Math.round(y) }));
    void this.events.surfaceAt(places).then((points) => {
      const depths = points.flatMap((point) => (point ? [depthOf(point, view)] : []));
      if (depths.length === 0) return this.events.failed("There is no surface inside the lasso to cut from.");
      this.add(this.editor.text(kField), lassoCut(kind, pixels, view, Math.min(...depths) + deepMm));
    });
  }

  /** Adds a ball where the surface is, if it is not too near to the one before. */
  private async erase(pointer: PagePoint): Promise<void> {
    const base = this.stroke?.base ?? this.editor.text(kField);
    const radiusMm = Number(this.radius.value);
    const view = this.events.view();
    const full = this.events.fullSize();
    const apart = view ? (kBallsApart * radiusMm * page.canvas.clientHeight) / (view.mmPerPixel * full.height) : 0;
    if (this.stroke && distance(this.stroke.last, pointer) < apart) return;
    this.stroke = { base, centres: this.stroke?.centres ?? [], last: pointer };
    const { stroke } = this;
    const { x, y } = this.pixelOf(pointer);
    const [point] = await this.events.surfaceAt([{ x: Math.round(x), y: Math.round(y) }]);
    if (!point) return;
    stroke.centres.push(point);
    this.add(base, ballsCut(radiusMm, stroke.centres));
  }

  private add(base: string, cut: string): void {
    const shapes = withCut(base, cut);
    if (shapes === undefined) return this.events.failed("There is no room for another cut: undo one, or restore all.");
    this.editor.set([[kField, shapes]]);
  }

  private draw(): void {
    const { left, top } = page.canvas.getBoundingClientRect();
    const points = this.line.map(({ x, y }) => `${(x - left).toFixed(1)} ${(y - top).toFixed(1)}`);
    this.drawn.replaceChildren(
      ...(points.length > 1 ? [drawing("path", { d: `M${points.join("L")}${this.dragging ? "Z" : ""}` })] : []),
      ...(this.dragging ? [] : this.line.map(({ x, y }) => drawing("circle", { cx: x - left, cy: y - top, r: 3 }))),
    );
  }
}

function distance(a: PagePoint, b: PagePoint): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

/** The longer side of the box around points. */
function extent(points: readonly PagePoint[]): number {
  const span = (values: number[]) => Math.max(...values) - Math.min(...values);
  return Math.max(span(points.map(({ x }) => x)), span(points.map(({ y }) => y)));
}
