// SPDX-License-Identifier: Apache-2.0
// The markers of the lights over the picture, and their movement by the pointer. One light is chosen: gestures and keys
// move that one.
import { kLamps, type Lamp } from "./lamps";
import type { SettingsEditor } from "./settings_editor";
import {
  pagePoint,
  picturePixel,
  pixelOf,
  scaleAt,
  surfacePart,
  tidy,
  viewPoint,
  type PagePoint,
  type Rectangle,
} from "./view_geometry";

const kNudge = 0.02; // share of the visible height, per nudge
const kReachPixels = 22; // of a marker, for a finger

/** In modes that light nothing there is no marker, and no light can be moved. A light that is off has no marker. */
export class LightHandles {
  /** Called when another light is chosen. */
  onChosen: (lamp: Lamp) => void = () => undefined;
  private wanted: Lamp = "light";

  constructor(
    private readonly editor: SettingsEditor,
    private readonly canvas: HTMLCanvasElement,
    private readonly markers: ReadonlyMap<Lamp, SVGElement>,
    private readonly isLit: () => boolean,
  ) {}

  /** The light that moves: the one that was chosen, or the first that is on. */
  get chosen(): Lamp {
    return this.isOn(this.wanted) ? this.wanted : (kLamps.find((lamp) => this.isOn(lamp)) ?? this.wanted);
  }

  choose(lamp: Lamp): void {
    this.wanted = lamp;
    this.placeMarkers();
    this.onChosen(lamp);
  }

  /** Chooses the light whose marker is under the pointer, if any. */
  chooseAt(pointer: PagePoint): void {
    const part = this.part();
    const on = kLamps.filter((lamp) => this.isOn(lamp) && this.markers.has(lamp));
    if (!part || on.length < 2) return;
    const apart = (lamp: Lamp) => {
      const at = pagePoint(clamped(this.pixel(lamp, part), part), this.canvas);
      return Math.hypot(at.x - pointer.x, at.y - pointer.y);
    };
    const nearest = on.reduce((best, lamp) => (apart(lamp) < apart(best) ? lamp : best));
    if (apart(nearest) <= kReachPixels) this.choose(nearest);
  }

  /** Moves the light to the pointer; its depth stays. */
  moveTo(pointer: PagePoint): void {
    const [part, lamp] = [this.part(), this.chosen];
    if (!part) return;
    const point = viewPoint(picturePixel(pointer, this.canvas), part, this.heightMm(lamp));
    this.editor.set([[`${lamp}.right_mm`, point.rightMm], [`${lamp}.up_mm`, point.upMm], ...this.switchedOn(lamp)]);
  }

  nudge(right: number, up: number): void {
    const lamp = this.chosen;
    if (!this.part()) return;
    const step = kNudge * this.heightMm(lamp);
    this.editor.set([
      [`${lamp}.right_mm`, tidy(this.editor.number(`${lamp}.right_mm`) + right * step)],
      [`${lamp}.up_mm`, tidy(this.editor.number(`${lamp}.up_mm`) + up * step)],
      ...this.switchedOn(lamp),
    ]);
  }

  /** Positive numbers move the light into the body. */
  deepen(nudges: number): void {
    const lamp = this.chosen;
    if (!this.part()) return;
    const depthMm = this.editor.number(`${lamp}.depth_mm`) + nudges * kNudge * this.editor.number("camera.field_mm");
    this.editor.set([[`${lamp}.depth_mm`, tidy(depthMm)], ...this.switchedOn(lamp)]);
  }

  /** Draws the markers. A light outside the lit part of the picture is drawn at the edge of that part. */
  placeMarkers(): void {
    const part = this.part();
    const several = kLamps.filter((lamp) => this.isOn(lamp)).length > 1;
    for (const [lamp, marker] of this.markers) {
      const shown = part !== undefined && this.isOn(lamp);
      marker.classList.toggle("absent", !shown);
      marker.classList.toggle("chosen", several && lamp === this.chosen);
      if (shown) this.place(marker, this.pixel(lamp, part), part);
    }
  }

  /** Where all lights are off, the one that is moved is switched on. */
  private switchedOn(lamp: Lamp): [string, number][] {
    return this.isOn(lamp) ? [] : [[`${lamp}.on`, 1]];
  }

  private place(marker: SVGElement, { x, y }: PagePoint, part: Rectangle): void {
    const [right, bottom] = [part.left + part.width, part.top + part.height];
    marker.classList.toggle("beside", x < part.left || x > right || y < part.top || y > bottom);
    const setFractions = (pixels: Record<string, number>, whole: number) => {
      for (const [name, pixel] of Object.entries(pixels)) marker.style.setProperty(name, String(pixel / whole));
    };
    setFractions({ "--x": x, "--left": part.left, "--right": right }, this.canvas.width);
    setFractions({ "--y": y, "--top": part.top, "--bottom": bottom }, this.canvas.height);
  }

  private isOn(lamp: Lamp): boolean {
    return this.editor.choice(`${lamp}.on`) === "on";
  }

  /** The pixel of the picture at which a light is seen. */
  private pixel(lamp: Lamp, part: Rectangle): PagePoint {
    const point = { rightMm: this.editor.number(`${lamp}.right_mm`), upMm: this.editor.number(`${lamp}.up_mm`) };
    return pixelOf(point, part, this.heightMm(lamp));
  }

  private part(): Rectangle | undefined {
    return this.isLit() ? surfacePart(this.editor.choice("mode"), this.canvas) : undefined;
  }

  /** Height in mm that the lit part covers at the depth of the light. */
  private heightMm(lamp: Lamp): number {
    const lens = {
      fieldMm: this.editor.number("camera.field_mm"),
      distanceMm: this.editor.number("camera.distance_mm"),
      perspective: this.editor.choice("camera.projection") === "perspective",
      openingDeg: this.editor.number("camera.opening_deg"),
    };
    return lens.fieldMm * scaleAt(this.editor.number(`${lamp}.depth_mm`), lens);
  }
}

function clamped({ x, y }: PagePoint, part: Rectangle): PagePoint {
  const within = (at: number, first: number, length: number) => Math.min(Math.max(at, first), first + length);
  return { x: within(x, part.left, part.width), y: within(y, part.top, part.height) };
}
