// SPDX-License-Identifier: Apache-2.0
// The surface of the picture on show, drawn by this display: lit by the scene as this page has it, and seen from its
// camera, so that what the hand does is seen at once. Where that takes the browser long, coarsely while it moves.
import { create } from "@bufbuild/protobuf";
import { SurfaceSchema, type Picture, type Surface, type View } from "../../generated/fanlight_pb.js";
import type { Rectangle } from "../view_geometry";
import { agreement, depthGrid, type DepthGrid } from "./depth_grid";
import { DrawingPace } from "./drawing_pace";
import { KeptPictures, type KeptPicture } from "./kept_pictures";
import { lightPlan, type LightPlan, type SceneValues } from "./light_parameters";
import { coarser, kNoSurface, unpackSurface, type DepthMap } from "./surface_decoder";
import { SurfaceLighter, type Cast } from "./surface_lighter";
import { bodyPoint, coarserView, degreesBetween, isFiner, sameView, sameViewInAnySize, viewOf } from "./view_of";

/** Beyond, too little of what would be seen is known. */
const kMostTurnedDeg = 60;
/** Height of the picture that is drawn to learn how long that takes. */
const kRehearsedSide = 170;
/** Of the pictures of a server, unless a display asks for more. */
const kUsualSize = { width: 512, height: 512 };
/** Casts of one volume from different views: a turn back finds what it has seen before. */
const kMostCasts = 3;

/** Two casts that differ by more show different things. */
const kAgreeMm = 2;

/** The surface that was drawn: its view, and how deep it lies. */
export interface DrawnDepths {
  view: View;
  grid: DepthGrid;
}

interface Shown {
  view: View;
  part: Rectangle;
  whole: boolean; // it covers the picture
  asDepth: boolean;
  key: string; // of the volume and the settings; "": not known
  maps: DepthMap[]; // by the pixels that became one, from 1
}

/** The scene as the page has it. */
export interface ShownScene extends SceneValues {
  /**
   * Of all settings that pass 1 and the filter depend on, but for the camera: surfaces of two values do not go together.
   * undefined for a picture from before they were in force.
   */
  castKey(sceneRevision: bigint): string | undefined;
}

export class SurfaceView {
  private lighter: SurfaceLighter | undefined;
  private received: DepthMap | undefined;
  private finer: KeptPicture | undefined; // of what was unpacked last
  private shown: Shown | undefined;
  private readonly kept = new KeptPictures();
  private casts: Shown[] = []; // of the volume on show, the newest first
  private castKey = "";
  private drawn: { level: number; scene: string; turned: boolean; of?: Shown; view?: View } = {
    level: 1,
    scene: "",
    turned: false,
  };
  private paces = { lit: new DrawingPace(), turned: new DrawingPace() };
  private readonly sample = document.createElement("canvas").getContext("2d", { willReadFrequently: true })!;

  constructor(private readonly scene: ShownScene) {}

  /** Whether this browser can light surfaces; makes what that needs. */
  get works(): boolean {
    if (this.lighter?.isLost) this.lighter = undefined;
    if (!("DecompressionStream" in window)) return false;
    try {
      this.lighter ??= new SurfaceLighter();
    } catch {
      return false;
    }
    return true;
  }

  /** Rejects where the surface is damaged. Shows nothing yet. False: the server has not sent the maps. */
  async unpack(picture: Picture): Promise<boolean> {
    const { surface } = picture;
    this.finer = undefined;
    if (!surface) return true;
    if (hasMaps(surface)) this.received = await unpackSurface(surface);
    const map = this.received;
    if (map?.id !== surface.surfaceId) return false;
    picture.surface = outlineOf(surface);
    const whole = surface.width === picture.width && surface.height === picture.height;
    const castKey = this.scene.castKey(picture.sceneRevision);
    if (!whole || castKey === undefined) return true;
    this.finer = this.kept.of(picture.volumeId);
    if (this.finer?.castKey !== castKey || !isFiner(this.finer.picture, picture)) this.finer = undefined;
    if (this.finer) takeOver(this.finer.picture, picture);
    else this.kept.add({ picture, map, castKey });
    return true;
  }

  /** What draw() draws from now on: the surface of a picture that was unpacked last; without one, nothing. */
  show({ surface, view, volumeId, sceneRevision, width: all }: Picture, map = this.finer?.map ?? this.received): void {
    this.shown = undefined;
    if (!surface || !view || !map || map.id !== surface.surfaceId) return;
    const { left, top, width, height } = surface;
    const whole = width === all;
    const key = this.keyOf(volumeId, sceneRevision);
    this.shown = { view, part: { left, top, width, height }, whole, asDepth: surface.asDepth, key, maps: [map] };
    this.keep(this.shown, key && `${width} ${height} ${key}`);
  }

  /** Whether showKept() can. */
  has(volumeId: bigint): boolean {
    const kept = this.kept.of(volumeId);
    return kept !== undefined && kept.castKey === this.scene.castKey(kept.picture.sceneRevision);
  }

  /** The same for a volume that was seen before by the present settings, but for light and camera; which picture. */
  showKept(volumeId: bigint): Picture | undefined {
    const kept = this.has(volumeId) ? this.kept.of(volumeId) : undefined;
    if (kept) this.show(kept.picture, kept.map);
    return kept?.picture;
  }

  /** The picture on show has no surface that this display could light. */
  forget(): void {
    this.shown = undefined;
    this.casts = [];
  }

  /** Call at the start of a session: ids are those of the last one. */
  forgetAll(): void {
    this.forget();
    this.received = undefined;
    this.kept.clear();
  }

  /** Whether the page's camera can be drawn from what was cast. */
  get canTurn(): boolean {
    if (!this.shown) return true;
    const wanted = viewOf(this.scene, this.shown.part);
    return degreesBetween(wanted, this.shown.view) <= kMostTurnedDeg;
  }

  /** Of what was drawn last, in pixels of the picture; undefined where the server draws. */
  get drawnView(): View | undefined {
    if (!this.shown) return undefined;
    return this.drawn.of === this.shown ? this.drawn.view : this.shown.view;
  }

  /** The point of the body at a pixel of the picture, mm; undefined without a surface, and in a turned picture. */
  pointAt({ x, y }: { x: number; y: number }): readonly [number, number, number] | undefined {
    const { shown } = this;
    if (!shown || this.isTurned) return undefined;
    const map = shown.maps[0]!;
    const [column, row] = [Math.floor(x) - shown.part.left, Math.floor(y) - shown.part.top];
    const units = map.depths[row * map.width + column];
    if (column < 0 || column >= map.width || units === undefined || units === kNoSurface) return undefined;
    return bodyPoint(shown.view, Math.floor(x), Math.floor(y), units * map.unitMm);
  }

  get isShown(): boolean {
    return this.shown !== undefined;
  }

  /** Whether this display draws all of the picture. */
  get isWhole(): boolean {
    return this.shown?.whole === true;
  }

  /** Whether draw() would turn it. */
  get isToTurn(): boolean {
    return this.shown !== undefined && this.wantedView(this.shown) !== this.shown.view;
  }

  /** Whether the picture is seen from another view than the server has cast it for. */
  get isTurned(): boolean {
    return this.shown !== undefined && this.drawn.turned;
  }

  /** Whether even the coarsest light takes so long that pictures of the server are quicker. */
  get isTooSlow(): boolean {
    return this.paces.lit.isTooSlow;
  }

  /** What was slow may have been the machine. */
  forgetPace(): void {
    this.paces = { lit: new DrawingPace(), turned: new DrawingPace() };
  }

  /** The most pixels of a surface that this browser lights without a wait. */
  get mostPixels(): number {
    return this.paces.lit.mostPixels;
  }

  get isCoarse(): boolean {
    return this.shown !== undefined && this.drawn.level > 1;
  }

  /** Whether the light, what it falls on, or the camera is not as it was drawn last. */
  get isOld(): boolean {
    return this.shown !== undefined && this.drawn.scene !== this.sceneOf(this.shown);
  }

  /** Draws the surface on show, if there is one, into its part of a picture. */
  draw(context: CanvasRenderingContext2D, moving: boolean): void {
    if (!this.shown || !this.works) return;
    const { shown } = this;
    const lighter = this.lighter!;
    const began = performance.now();
    const wanted = this.wantedView(shown);
    const turned = wanted !== shown.view;
    const pace = turned ? this.paces.turned : this.paces.lit;
    const level = moving ? pace.levelOf(shown.part) : 1;
    const map = mapOf(shown, level);
    const plan = this.planAt(level, shown, wanted);
    if (turned) this.drawTurned(lighter, level, shown, wanted, plan);
    else lighter.draw(level, map, plan);
    const { left, top } = shown.part;
    context.drawImage(lighter.canvas, left, top, level * map.width, level * map.height);
    this.drawn = { level, scene: this.sceneOf(shown), turned, of: shown, view: wanted };
    if (moving && pace.learns) pace.learn(map, this.waited(lighter.canvas) - began);
  }

  /** How deep what is drawn now lies, for agreesWith() after show(next); undefined where that shows something else. */
  depthsBefore({ surface, volumeId, sceneRevision }: Picture): DrawnDepths | undefined {
    const { shown, drawn } = this;
    if (!shown?.whole || !drawn.view || drawn.of !== shown) return undefined;
    // Of the same surface only the light differs.
    if (shown.maps[0]!.id === surface?.surfaceId || shown.key !== this.keyOf(volumeId, sceneRevision)) return undefined;
    const turned = drawn.turned ? this.lighter?.turnedDepths(drawn.level) : undefined;
    if (drawn.turned && !turned) return undefined;
    const grid = turned
      ? depthGrid(turned.size, (column, row) => turned.depthsMm[row * turned.size.width + column]!)
      : gridOf(shown.maps[0]!);
    return { view: drawn.view, grid };
  }

  /** Where the picture on show agrees with what was drawn before; undefined where that is of another view. */
  agreesWith(before: DrawnDepths | undefined): { mask: Uint8ClampedArray; grid: DepthGrid } | undefined {
    const { shown } = this;
    if (!before || !shown?.whole || !sameViewInAnySize(before.view, shown.view)) return undefined;
    const grid = gridOf(shown.maps[0]!);
    const mask = agreement(before.grid, grid, kAgreeMm);
    return mask.length > 0 ? { mask, grid } : undefined;
  }

  /**
   * Draws what nobody sees, so that the first movement of a hand waits for no shader, and begins as coarsely as this
   * browser needs it.
   */
  rehearse(): void {
    const { lighter, shown } = this;
    if (!lighter || !shown || lighter.isLost) return;
    const level = Math.max(1, Math.round(shown.part.height / kRehearsedSide));
    const map = mapOf(shown, level);
    const plan = this.planAt(level, shown, shown.view);
    const draws = {
      lit: () => lighter.draw(level, map, plan),
      turned: () => lighter.turns && this.drawTurned(lighter, level, shown, shown.view, plan),
    };
    for (const way of ["lit", "turned"] as const) {
      draws[way](); // compiles, and is not measured
      const timesMs = [0, 1].map(() => {
        const began = this.waited(lighter.canvas);
        draws[way]();
        return this.waited(lighter.canvas) - began;
      });
      this.paces[way].learn(map, Math.min(...timesMs)); // the machine may have been busy in one
    }
  }

  private drawTurned(lighter: SurfaceLighter, level: number, shown: Shown, wanted: View, plan: LightPlan): void {
    const { left, top } = shown.part;
    const inPart = (view: View) => {
      const coarse = coarserView(view, level);
      coarse.middleColumn -= left / level;
      coarse.middleRow -= top / level;
      return coarse;
    };
    const casts = [...this.casts].sort((a, b) => degreesBetween(a.view, wanted) - degreesBetween(b.view, wanted));
    // Where the browser is slow, the nearest one alone.
    const usable: Cast[] = casts
      .slice(0, this.paces.turned.levelOf(kUsualSize) > 2 ? 1 : kMostCasts)
      .map((cast) => ({ map: mapOf(cast, level), view: inPart(cast.view) }));
    lighter.drawTurned(level, usable, inPart(wanted), plan, this.scene.number("rays.start_mm"));
  }

  private keyOf(volumeId: bigint, sceneRevision: bigint): string {
    const castKey = this.scene.castKey(sceneRevision);
    return castKey === undefined ? "" : `${volumeId} ${castKey}`;
  }

  private keep(cast: Shown, key: string): void {
    if (key === "" || key !== this.castKey) this.casts = [];
    this.castKey = key;
    this.casts = [cast, ...this.casts.filter((other) => !sameView(other.view, cast.view))].slice(0, kMostCasts);
  }

  /** The view of the page's camera; that of the picture where it is the same, or where it cannot be turned so far. */
  private wantedView({ view, part }: Shown): View {
    const wanted = viewOf(this.scene, part);
    const near = !sameView(wanted, view) && degreesBetween(wanted, view) <= kMostTurnedDeg;
    return near && this.lighter?.turns ? wanted : view;
  }

  private sceneOf(shown: Shown): string {
    const wanted = this.wantedView(shown);
    return JSON.stringify([this.planAt(1, shown, wanted), wanted.matrix]);
  }

  private planAt(level: number, { part, asDepth }: Shown, view: View): LightPlan {
    const coarse = {
      left: part.left / level,
      top: part.top / level,
      width: Math.ceil(part.width / level),
      height: Math.ceil(part.height / level),
    };
    return lightPlan(this.scene, coarserView(view, level), coarse, asDepth);
  }

  /** The time when the canvas is drawn: most browsers draw later. To read a pixel waits for that. */
  private waited(canvas: HTMLCanvasElement): number {
    this.sample.drawImage(canvas, 0, 0, 1, 1);
    this.sample.getImageData(0, 0, 1, 1);
    return performance.now();
  }
}

function gridOf({ width, height, depths, unitMm }: DepthMap): DepthGrid {
  return depthGrid({ width, height }, (column, row) => {
    const units = depths[row * width + column]!;
    return units === kNoSurface ? -1 : units * unitMm;
  });
}

function hasMaps(surface: Surface): boolean {
  return surface.runs.length > 0;
}

/** The server shows again, and more coarsely, what this display still has: this shows it as it was. */
function takeOver({ width, height, surface, view }: Picture, to: Picture): void {
  Object.assign(to, { width, height, surface, view });
}

/** The surface without its maps. */
function outlineOf({ surfaceId, left, top, width, height, asDepth }: Surface): Surface {
  return create(SurfaceSchema, { surfaceId, left, top, width, height, asDepth });
}

function mapOf({ maps }: Shown, level: number): DepthMap {
  return (maps[level - 1] ??= coarser(maps[0]!, level));
}
