// SPDX-License-Identifier: Apache-2.0
// Measures distances on the frozen surface: two clicks, the straight distance, and the one along the surface.
import type { DepthReply, DepthReply_Point as Point, Picture, View } from "../generated/fanlight_pb.js";
import { drawing } from "./element";
import { picturePixel, type PagePoint, type Size } from "./view_geometry";

const kDrawnHeight = 512; // of the picture, in the units of what is drawn over it
const kPixelsApart = 3; // nearer samples add the depth map's noise to the path
const kMostPoints = 1024; // of a request
const kSecondPoint = "Now the second point.";
export const kNotForDiagnosis = "Not for diagnosis.";

/** x, y, z in the transducer frame. */
export type Mm = readonly [number, number, number];

export interface Distance {
  straightMm: number;
  /** Along the surface between the points; absent where the path leaves the surface. */
  alongMm: number | undefined;
}

/** Pixels from one to the other, both included, about kPixelsApart apart in a picture of the usual height. */
export function pathPixels(from: PagePoint, to: PagePoint, height = kDrawnHeight): PagePoint[] {
  const apart = (kPixelsApart * height) / kDrawnHeight;
  const steps = Math.hypot(to.x - from.x, to.y - from.y) / apart;
  const count = Math.min(kMostPoints - 1, Math.max(1, Math.round(steps)));
  return Array.from({ length: count + 1 }, (_, index) => {
    const share = index / count;
    return { x: Math.round(from.x + share * (to.x - from.x)), y: Math.round(from.y + share * (to.y - from.y)) };
  });
}

/** undefined where an end is not on the surface. */
export function distanceOf(points: readonly Pick<Point, "surface" | "xMm" | "yMm" | "zMm">[]): Distance | undefined {
  const [first, last] = [points[0], points.at(-1)];
  if (!first?.surface || !last?.surface) return undefined;
  const apart = (a: typeof first, b: typeof first) => Math.hypot(a.xMm - b.xMm, a.yMm - b.yMm, a.zMm - b.zMm);
  const whole = points.every((point) => point.surface);
  const along = points.slice(1).reduce((sum, point, index) => sum + apart(points[index]!, point), 0);
  return { straightMm: apart(first, last), alongMm: whole ? along : undefined };
}

export function distanceText({ straightMm, alongMm }: Distance): string {
  const along = alongMm === undefined ? "the path leaves the surface" : `${alongMm.toFixed(1)} mm along the surface`;
  return `${straightMm.toFixed(1)} mm straight, ${along}. ${kNotForDiagnosis}`;
}

function pixelAt({ x, y }: PagePoint, { width, height }: Size): PagePoint {
  return { x: Math.floor(x * width), y: Math.floor(y * height) };
}

/** The pixel, in the size that the view is of, of a point in the transducer frame. */
export function pixelOfPoint([x, y, z]: Mm, view: View): PagePoint | undefined {
  const m = view.matrix;
  if (m.length !== 16) return undefined;
  const from = [x - m[3]!, y - m[7]!, z - m[11]!] as const;
  const along = (column: number) => from[0] * m[column]! + from[1] * m[4 + column]! + from[2] * m[8 + column]!;
  const scale = view.mmPerPixel + along(2) * view.mmPerPixelPerMm;
  if (!(scale > 0)) return undefined;
  return { x: view.middleColumn + along(0) / scale, y: view.middleRow + along(1) / scale };
}

interface Measured {
  volumeId: bigint;
  path: Mm[];
  distance: Distance;
}

export class Measurement {
  private start: PagePoint | undefined; // the first click, in shares of the picture's width and height
  private measured: Measured | undefined;
  private pending: { id: bigint; pictureId: bigint } | undefined;
  private lastId = 0n;
  private picture: Picture | undefined;
  private chosen = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly overlay: SVGSVGElement,
    private readonly events: {
      isFrozen(): boolean;
      mayFreeze(): boolean;
      freeze(): void;
      showsSurface(): boolean;
      fullSize(): Size;
      /** Whether the picture has a part that points of the body are drawn on. */
      showsBody(): boolean;
      ask(requestId: bigint, pixels: PagePoint[]): void;
      /** Empty: nothing to say. */
      say(sentence: string): void;
    },
  ) {}

  /** The tool was chosen, or left. */
  choose(chosen: boolean): void {
    this.chosen = chosen;
    this.start = undefined;
    if (chosen) this.freeze();
    this.events.say(chosen ? this.hint() : "");
    this.draw();
  }

  /** Begins a session: what was measured before is of another one. */
  forget(): void {
    this.start = this.measured = this.pending = this.picture = undefined;
    this.draw();
  }

  /** The picture was frozen, or is live again. */
  frozenChanged(): void {
    if (!this.chosen || (this.isShown() && this.events.isFrozen())) return;
    this.measured = undefined;
    if (!this.events.isFrozen()) this.start = undefined;
    this.events.say(this.start ? kSecondPoint : this.hint());
    this.draw();
  }

  clicked(pointer: PagePoint): void {
    if (!this.canMeasure() || !this.picture) {
      this.freeze();
      return this.events.say(this.hint());
    }
    const { x, y } = picturePixel(pointer, this.canvas);
    const full = this.events.fullSize();
    const within = (at: number, size: number) => Math.min(size - 1, Math.max(0, Math.floor(at)));
    const pixel = {
      x: within((x * full.width) / this.canvas.width, full.width),
      y: within((y * full.height) / this.canvas.height, full.height),
    };
    if (!this.start) {
      this.start = { x: (pixel.x + 0.5) / full.width, y: (pixel.y + 0.5) / full.height };
      this.measured = undefined;
      this.events.say(kSecondPoint);
    } else {
      this.pending = { id: (this.lastId += 1n), pictureId: this.picture.pictureId };
      this.events.ask(this.lastId, pathPixels(pixelAt(this.start, full), pixel, full.height));
      this.start = undefined;
    }
    this.draw();
  }

  answered({ requestId, pictureId, points, refused }: DepthReply): void {
    const asked = this.pending;
    if (!asked || requestId !== asked.id) return;
    this.pending = undefined;
    if (!refused && pictureId !== asked.pictureId) return this.events.say("The picture has changed. Measure again.");
    const distance = distanceOf(points);
    if (refused || !distance || !this.picture) {
      return this.events.say(refused?.message ?? "A point is not on the surface. Click two points of the surface.");
    }
    const path = points.filter((point) => point.surface).map(({ xMm, yMm, zMm }) => [xMm, yMm, zMm] as const);
    this.measured = { volumeId: this.picture.volumeId, path, distance };
    this.events.say(distanceText(distance));
    this.draw();
  }

  /** The picture on show; a measurement belongs to its volume. */
  show(picture: Picture): void {
    const isSame = (["volumeId", "sceneRevision", "privateView"] as const).every(
      (name) => this.picture?.[name] === picture[name],
    );
    this.picture = picture;
    const isOver = this.measured !== undefined && !this.isShown();
    if ((!isSame && this.start) || isOver) {
      this.start = undefined;
      if (isOver) this.measured = undefined;
      this.events.say(this.chosen ? this.hint() : "");
    }
    this.draw();
  }

  /** For a still: the text next to the measurement that is drawn. */
  text(): string {
    return this.isShown() && this.events.showsBody() ? distanceText(this.measured!.distance) : "";
  }

  private isShown(): boolean {
    return this.measured !== undefined && this.measured.volumeId === this.picture?.volumeId;
  }

  /** A moving surface cannot be measured. */
  private freeze(): void {
    if (this.events.showsSurface() && !this.events.isFrozen() && this.events.mayFreeze()) this.events.freeze();
  }

  private canMeasure(): boolean {
    return this.events.isFrozen() && this.events.showsSurface();
  }

  private hint(): string {
    if (!this.events.showsSurface()) return "This picture shows no surface to measure on. Choose Face, or one pane.";
    if (this.events.isFrozen()) return "Click two points of the surface.";
    return this.events.mayFreeze()
      ? "Click two points: the first click freezes the picture."
      : "Only a picture that is frozen for all displays can be measured: the display in control freezes it.";
  }

  private draw(): void {
    const full = this.events.fullSize();
    // Lines and texts have one size whatever that of the picture.
    const scale = kDrawnHeight / (full.height || 1);
    this.overlay.setAttribute("viewBox", `0 0 ${scale * (full.width || 1)} ${kDrawnHeight}`);
    const parts: SVGElement[] = [];
    // A pixel is drawn at its middle.
    const drawn = ({ x, y }: PagePoint) => ({ x: scale * (x + 0.5), y: scale * (y + 0.5) });
    const cross = ({ x, y }: PagePoint) => drawing("path", { d: `M${x - 6} ${y}h12M${x} ${y - 6}v12` });
    if (this.start) parts.push(cross(drawn(pixelAt(this.start, full))));
    const view = this.picture?.view;
    if (this.isShown() && view && this.events.showsBody()) {
      const pixels = this.measured!.path.map((point) => pixelOfPoint(point, view));
      if (pixels.every((pixel) => pixel !== undefined)) {
        const all = (pixels as PagePoint[]).map(drawn);
        const [from, to] = [all[0]!, all.at(-1)!];
        const path = all.map(({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
        const label = drawing("text", { x: (from.x + to.x) / 2 + 8, y: (from.y + to.y) / 2 - 8 });
        label.textContent = `${this.measured!.distance.straightMm.toFixed(1)} mm`;
        parts.push(drawing("path", { d: `M${from.x} ${from.y}L${to.x} ${to.y}` }));
        parts.push(drawing("path", { d: `M${path}`, class: "path" }), cross(from), cross(to), label);
      }
    }
    this.overlay.replaceChildren(...parts);
  }
}
