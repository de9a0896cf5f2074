// SPDX-License-Identifier: Apache-2.0
// The surface of the picture on show, lit by this display: by the scene as this page has it, so that a moved light is
// seen at once. Where that takes the browser long, coarsely while the light moves.
import { create } from "@bufbuild/protobuf";
import { ViewSchema, type Picture, type Surface, type View } from "../../generated/fanlight_pb.js";
import type { Rectangle } from "../view_geometry";
import { lightPlan, type LightPlan, type SceneValues } from "./light_parameters";
import { coarser, unpackSurface, type DepthMap } from "./surface_decoder";
import { SurfaceLighter } from "./surface_lighter";

/** A picture in motion takes no longer, if it can be had by fewer pixels. */
const kMovingMs = 35;
const kCoarsest = 3;
const kLearnEvery = 10;

interface Shown {
  view: View;
  part: Rectangle;
  asDepth: boolean;
  maps: DepthMap[]; // by the pixels that became one, from 1
}

export class SurfaceView {
  private lighter: SurfaceLighter | undefined;
  private received: DepthMap | undefined;
  private shown: Shown | undefined;
  private drawn = { level: 1, scene: "" };
  private movingLevel = 1;
  private untilLearning = 0; // pictures in motion
  private readonly sample = document.createElement("canvas").getContext("2d", { willReadFrequently: true })!;

  constructor(private readonly scene: SceneValues) {}

  /** Whether this browser can light surfaces; makes what that needs. */
  get works(): boolean {
    if (this.lighter?.isLost) this.lighter = undefined;
    try {
      this.lighter ??= new SurfaceLighter();
    } catch {
      return false;
    }
    return true;
  }

  /** Rejects where the surface is damaged, or is another one than the server has sent. */
  async take({ surface, view }: Picture): Promise<void> {
    const map = surface && (hasMaps(surface) ? await unpackSurface(surface) : this.received);
    this.shown = undefined;
    if (!surface || !view || !this.works) return;
    if (map?.id !== surface.surfaceId) throw new Error("The server has left out a surface.");
    this.received = map;
    const { left, top, width, height } = surface;
    this.shown = { view, part: { left, top, width, height }, asDepth: surface.asDepth, maps: [map] };
  }

  /** The picture on show has no surface that this display could light. */
  forget(): void {
    this.shown = undefined;
  }

  /** Draws the surface on show, if there is one, into its part of a picture. */
  draw(context: CanvasRenderingContext2D, moving: boolean): void {
    const { lighter, shown } = this;
    if (!lighter || !shown || lighter.isLost) return;
    const began = performance.now();
    const level = moving ? this.movingLevel : 1;
    const map = (shown.maps[level - 1] ??= coarser(shown.maps[0]!, level));
    const plan = this.planAt(level, shown);
    lighter.draw(level, map, plan);
    const { left, top } = shown.part;
    context.drawImage(lighter.canvas, left, top, level * map.width, level * map.height);
    this.drawn = { level, scene: this.sceneOf(shown) };
    if (moving) this.learn(lighter.canvas, began);
  }

  /** Whether the light, or what it falls on, is not as it was drawn last. */
  get isOld(): boolean {
    return this.shown !== undefined && this.drawn.scene !== this.sceneOf(this.shown);
  }

  get isCoarse(): boolean {
    return this.shown !== undefined && this.drawn.level > 1;
  }

  private sceneOf(shown: Shown): string {
    return JSON.stringify(this.planAt(1, shown));
  }

  private planAt(level: number, { view, part, asDepth }: Shown): LightPlan {
    const coarse = {
      left: part.left / level,
      top: part.top / level,
      width: Math.ceil(part.width / level),
      height: Math.ceil(part.height / level),
    };
    return lightPlan(this.scene, coarserView(view, level), coarse, asDepth);
  }

  /** Chooses how coarsely to draw the next picture in motion. */
  private learn(canvas: HTMLCanvasElement, began: number): void {
    if (--this.untilLearning > 0) return;
    // Most browsers draw later. To read a pixel waits for that.
    this.sample.drawImage(canvas, 0, 0, 1, 1);
    this.sample.getImageData(0, 0, 1, 1);
    const before = this.movingLevel;
    const tookMs = performance.now() - began;
    const finerMs = (tookMs * this.movingLevel ** 2) / Math.max(this.movingLevel - 1, 1) ** 2;
    if (tookMs > kMovingMs && this.movingLevel < kCoarsest) ++this.movingLevel;
    else if (finerMs < kMovingMs / 2 && this.movingLevel > 1) --this.movingLevel;
    this.untilLearning = this.movingLevel === before ? kLearnEvery : 1;
  }
}

function hasMaps(surface: Surface): boolean {
  return surface.runs.length > 0;
}

/** Of a picture of which each pixel is the first of level x level ones. */
function coarserView(view: View, level: number): View {
  if (level === 1) return view;
  return create(ViewSchema, {
    ...view,
    mmPerPixel: view.mmPerPixel * level,
    mmPerPixelPerMm: view.mmPerPixelPerMm * level,
    middleColumn: view.middleColumn / level,
    middleRow: view.middleRow / level,
  });
}
