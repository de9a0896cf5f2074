// SPDX-License-Identifier: Apache-2.0
// The scalpel: a lasso or a ball over the picture cuts away what it covers, in the body, for every display.
import type { View } from "../generated/fanlight_pb.js";
import {
  ballsCut,
  cutsOf,
  cutsText,
  depthOf,
  lassoCut,
  pixelMmAt,
  placesInside,
  pointAt,
  simplified,
  withCut,
  type LassoKind,
} from "./cut_shapes";
import { drawing, find } from "./element";
import type { Mm } from "./measuring/figures";
import { page } from "./page";
import type { SettingsEditor } from "./settings_editor";
import type { SurfaceAnswer } from "./surface_points";
import { picturePixel, surfacePart, type PagePoint, type Size } from "./view_geometry";

const kField = "cuts.shapes";
const kApartPixels = 3; // of the page, between points of a lasso
const kClosePixels = 14; // a corner so near to the first or the last one closes the lasso
const kBallsApart = 0.5; // of a radius
const kMostBallsAtOnce = 40; // between two events of the pointer
const kLassoHint = "Drag around what to cut away. Or click the corners, and the first one once more.";
const kBallHint = "Drag over what to cut away.";
const kMoved = "The view has changed. Draw the lasso again.";

export interface ScalpelEvents {
  /** The view of what is drawn. */
  view(): View | undefined;
  /** The size in which its pixels are counted. */
  fullSize(): Size;
  /** The points of the body at these pixels; undefined where the server does not answer. */
  surfaceAt(pixels: PagePoint[]): Promise<SurfaceAnswer | undefined>;
  /** Whether this display has turned the picture, so that its surface is not known. */
  isPreview(): boolean;
  say(sentence: string): void;
  failed(sentence: string): void;
}

/** A line over the picture, in pixels of a view. It ends where the view changes. */
interface Lasso {
  view: View;
  size: Size;
  pixels: PagePoint[];
  last: PagePoint; // of the page
}

/** Balls that are cut one after the other with one movement. */
interface Stroke {
  /** What was cut before its first ball. */
  base: string;
  view: View;
  centres: Mm[];
  /** Where the last ball was wanted, pixel. */
  last: PagePoint;
  depthMm?: number;
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
  private dragging = false;
  private lasso: Lasso | undefined;
  private stroke: Stroke | undefined;

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
    const text = this.text();
    this.root.hidden = !this.chosen;
    this.restore.hidden = text === "";
    this.mark.textContent = text;
    this.mark.hidden = text === "";
  }

  /** For the mark, and for a still. */
  text(): string {
    return cutsText(this.editor.text(kField));
  }

  begin(pointer: PagePoint): void {
    this.cancel();
    if (!this.may(pointer)) return;
    this.dragging = true;
    this.move(pointer);
  }

  move(pointer: PagePoint): void {
    if (!this.dragging) return;
    if (this.isBall) return this.erase(pointer);
    if (this.lasso && distance(this.lasso.last, pointer) < kApartPixels) return;
    this.addCorner(pointer);
  }

  end(): void {
    const { dragging } = this;
    this.dragging = false;
    this.stroke = undefined;
    if (dragging && !this.isBall) this.close();
  }

  cancel(): void {
    this.dragging = false;
    this.lasso = this.stroke = undefined;
    this.draw();
  }

  /** A click, or Enter at the cross that keys move: a ball, or a corner of a lasso. */
  clicked(pointer: PagePoint): void {
    if (!this.may(pointer)) return;
    if (this.isBall) {
      this.stroke = undefined;
      this.erase(pointer);
      this.stroke = undefined;
      return;
    }
    const corners = this.lasso?.pixels ?? [];
    const here = this.pixelOf(pointer);
    const near = (corner: PagePoint | undefined) =>
      corner !== undefined && distance(corner, here) < kClosePixels * this.pixelsOfAPagePixel();
    if (corners.length >= 3 && [corners[0], corners.at(-1)].some(near)) return this.close();
    this.addCorner(pointer);
  }

  /** What is drawn now may have another view: a lasso that was begun in the one before is given up. */
  viewMayHaveChanged(): void {
    if (!this.lasso || this.isView(this.lasso)) return;
    this.cancel();
    this.events.failed(kMoved);
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
    if (!this.allowed) return "You are not in control, or in a view of your own: nothing is cut.";
    if (!this.isInSurface(this.pixelOf(pointer))) return "Draw in the 3D picture. The planes show where a cut ends.";
    if (this.needsSurface && this.events.isPreview()) return "This is a preview: wait for the picture of the server.";
    return this.events.view()?.matrix.length === 16 ? "" : "There is no picture to cut in yet.";
  }

  private get needsSurface(): boolean {
    return this.isBall || this.deepMm > 0;
  }

  /** How deep a lasso cuts from the surface; 0: through everything. */
  private get deepMm(): number {
    return this.shape.value === "inside" ? Number(this.depth.value) : 0;
  }

  /** In pixels of the view; 0 is the middle of the first one. */
  private pixelOf(pointer: PagePoint): PagePoint {
    const full = this.events.fullSize();
    const { x, y } = picturePixel(pointer, page.canvas);
    return { x: (x * full.width) / page.canvas.width - 0.5, y: (y * full.height) / page.canvas.height - 0.5 };
  }

  private pixelsOfAPagePixel(): number {
    return this.events.fullSize().height / (page.canvas.clientHeight || 1);
  }

  private isInSurface({ x, y }: PagePoint): boolean {
    const part = surfacePart(this.editor.choice("mode"), this.events.fullSize());
    if (!part) return false;
    const [column, row] = [Math.round(x) - part.left, Math.round(y) - part.top];
    return column >= 0 && row >= 0 && column < part.width && row < part.height;
  }

  private isView({ view, size }: Lasso): boolean {
    const [now, full] = [this.events.view(), this.events.fullSize()];
    if (!now || full.width !== size.width || full.height !== size.height) return false;
    return (
      now === view ||
      (now.mmPerPixel === view.mmPerPixel &&
        now.mmPerPixelPerMm === view.mmPerPixelPerMm &&
        now.matrix.every((value, index) => value === view.matrix[index]))
    );
  }

  private addCorner(pointer: PagePoint): void {
    const view = this.events.view();
    if (!view) return;
    this.lasso ??= { view, size: this.events.fullSize(), pixels: [], last: pointer };
    this.viewMayHaveChanged();
    if (!this.lasso) return;
    this.lasso.pixels.push(this.pixelOf(pointer));
    this.lasso.last = pointer;
    this.draw();
  }

  private close(): void {
    const { lasso } = this;
    this.cancel();
    if (!lasso) return;
    const { view, pixels } = lasso;
    if (simplified(pixels).length < 3) return this.events.failed("The lasso surrounds nothing. Draw a wider one.");
    const kind = this.shape.value as LassoKind;
    const planeMm = this.editor.number("camera.distance_mm");
    const { deepMm } = this;
    if (deepMm === 0) return this.add(this.editor.text(kField), lassoCut(kind, pixels, view, planeMm));
    const places = placesInside(pixels).map(({ x, y }) => ({ x: Math.round(x), y: Math.round(y) }));
    void this.events.surfaceAt(places.filter((place) => this.isInSurface(place))).then((points) => {
      if (!points) return this.events.failed("The server does not say where the surface is. Try again.");
      const depths = points.flatMap((point) => (point ? [depthOf(point, view)] : []));
      if (depths.length === 0) return this.events.failed("There is no surface inside the lasso to cut from.");
      this.add(this.editor.text(kField), lassoCut(kind, pixels, view, planeMm, Math.min(...depths) + deepMm), {});
    });
  }

  /** Balls from the last one to the pointer. */
  private erase(pointer: PagePoint): void {
    const view = this.events.view();
    if (!view) return;
    const here = this.pixelOf(pointer);
    const begins = this.stroke === undefined;
    this.stroke ??= { base: this.editor.text(kField), view, centres: [], last: here };
    const { stroke } = this;
    const radiusMm = Number(this.radius.value);
    const pixelMm = pixelMmAt(view, this.editor.number("camera.distance_mm"));
    const apart = Math.max(1, (kBallsApart * radiusMm) / Math.max(pixelMm, 1e-3));
    const steps = Math.min(kMostBallsAtOnce, Math.floor(distance(stroke.last, here) / apart));
    if (steps === 0 && !begins) return;
    const from = stroke.last;
    const between = (share: number) => ({
      x: from.x + share * (here.x - from.x),
      y: from.y + share * (here.y - from.y),
    });
    const wanted = begins ? [here] : Array.from({ length: steps }, (_, index) => between((index + 1) / steps));
    stroke.last = here;
    const places = wanted
      .map(({ x, y }) => ({ x: Math.round(x), y: Math.round(y) }))
      .filter((place) => this.isInSurface(place));
    if (places.length === 0) return;
    void this.events.surfaceAt(places).then((points) => this.eraseAt(stroke, radiusMm, places, points));
  }

  private eraseAt(stroke: Stroke, radiusMm: number, places: PagePoint[], points: SurfaceAnswer | undefined): void {
    const before = stroke.centres.length;
    if (before === 0) stroke.base = this.editor.text(kField);
    // Others have cut meanwhile, or this was taken back.
    const written = cutsOf(stroke.base).length + (before > 0 ? 1 : 0);
    if (!points || cutsOf(this.editor.text(kField)).length !== written) return;
    places.forEach((place, index) => {
      const point = points[index];
      const depthMm = point && depthOf(point, stroke.view);
      // What is seen through the hole that this stroke has cut is not its surface.
      const isBehind = stroke.depthMm !== undefined && (depthMm === undefined || depthMm > stroke.depthMm + radiusMm);
      if (depthMm !== undefined && !isBehind) stroke.depthMm = depthMm;
      if (stroke.depthMm === undefined) return;
      stroke.centres.push(isBehind || !point ? pointAt(place, stroke.depthMm, stroke.view) : point);
    });
    if (stroke.centres.length > before) this.add(stroke.base, ballsCut(radiusMm, stroke.centres), stroke);
    else if (before === 0) this.events.failed("There is no surface here to cut away.");
  }

  /** `gesture`: see SettingsEditor.set(). Answers for a stroke arrive after the hand is lifted, too. */
  private add(base: string, cut: string, gesture?: object): void {
    const shapes = withCut(base, cut);
    if (shapes === undefined) return this.events.failed("There is no room for another cut: undo one, or restore all.");
    this.editor.set([[kField, shapes]], gesture);
  }

  private draw(): void {
    const { width, height } = this.lasso?.size ?? { width: 1, height: 1 };
    const scale = { x: page.canvas.clientWidth / width, y: page.canvas.clientHeight / height };
    const points = (this.lasso?.pixels ?? []).map(({ x, y }) => ({ x: (x + 0.5) * scale.x, y: (y + 0.5) * scale.y }));
    const path = points.map(({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
    this.drawn.replaceChildren(
      ...(points.length > 1 ? [drawing("path", { d: `M${path}${this.dragging ? "Z" : ""}` })] : []),
      ...(this.dragging ? [] : points.map(({ x, y }) => drawing("circle", { cx: x, cy: y, r: 3 }))),
    );
  }
}

function distance(a: PagePoint, b: PagePoint): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
