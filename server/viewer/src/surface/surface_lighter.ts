// SPDX-License-Identifier: Apache-2.0
// Passes 2 and 3 of the renderer from the light on, by WebGL 2: shades a depth map that the server has filtered, also as
// it would be seen from another view. The formulas are those of the server, in the same text (shaders/web). What does
// not depend on the light is prepared once.
import diffuseShader from "diffuse.frag";
import finishShader from "finish.frag";
import lightShader from "light.frag";
import outlineShader from "outline.frag";
import pictureShader from "picture.vert";
import prepareShader from "prepare.frag";
import prepareSoftShader from "prepare_soft.frag";
import scatterShader from "scatter.frag";
import softLightShader from "soft_light.frag";
import turnFragmentShader from "turn.frag";
import turnVertexShader from "turn.vert";
import type { View } from "../../generated/fanlight_pb.js";
import { LightLevel, type Frame, type Size } from "./light_level";
import type { LightPlan } from "./light_parameters";
import { MapStore } from "./map_textures";
import { Program, type Constants, type Uniforms } from "./program";
import type { DepthMap } from "./surface_decoder";
import { turnBetween } from "./view_of";

const kDeepestMm = 1e9; // FANLIGHT_MAX_DEPTH
const kNoSurface = -1; // FANLIGHT_NO_SURFACE
// Members of the parameters that the prepared maps depend on.
const kPreparedBy =
  "centre pixel view_scale_at_0 view_scale_per_mm same_surface central_normals occlusion occlusion_reach fade_reach";
// A step between neighbours of that many of their distances is no slope: it is steeper than 80 degrees.
const kSteepest = 6;
// The cast nearest to the view is seen before what others show.
const kBehindMm = 0.7;

/** A depth map and the view that it was cast for. */
export interface Cast {
  map: DepthMap;
  view: View;
}

export class SurfaceLighter {
  readonly canvas = document.createElement("canvas");
  /** Whether this browser can turn surfaces. */
  readonly turns: boolean;
  private readonly gl: WebGL2RenderingContext;
  private readonly maps: MapStore;
  private readonly programs = new Map<string, Program>();
  private readonly levels = new Map<number, LightLevel>();

  /** Throws where the browser has no WebGL 2 that draws to half floats. */
  constructor() {
    const gl = this.canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false });
    if (!gl) throw new Error("This browser has no WebGL 2.");
    this.turns = gl.getExtension("EXT_color_buffer_float") !== null;
    if (!this.turns && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new Error("This browser's WebGL draws no half floats.");
    this.gl = gl;
    this.maps = new MapStore(gl);
  }

  /** Whether the browser has taken the GPU away; it may come back with a new object. */
  get isLost(): boolean {
    return this.gl.isContextLost();
  }

  /** Draws a map to `canvas`. Maps of one `level` have one size, mostly: its memory is used again. */
  draw(level: number, map: DepthMap, plan: LightPlan): void {
    const here = this.levelOf(level, map);
    const values = uniformsOf(plan, { depth_unit: map.unitMm, nearest: Math.min(map.nearestMm, kDeepestMm) });
    const textures = { ...this.maps.texturesOf(map) };
    if (here.preparedOf !== map) here.preparedFor = "";
    here.preparedOf = map;
    this.light(here, plan, values, textures, {});
  }

  /** Draws maps as they would be seen in `view`, that of `plan`. The first one is seen before the others. */
  drawTurned(level: number, casts: readonly Cast[], view: View, plan: LightPlan, startMm: number): void {
    const here = this.levelOf(level, casts[0]!.map);
    this.turn(here, casts, view, startMm);
    // Shadow rays end above the nearest surface. What comes nearer by the turn is not known.
    const values = uniformsOf(plan, { nearest: startMm });
    here.preparedOf = undefined;
    here.preparedFor = "";
    this.light(here, plan, values, { turned: here.turned.texture }, { FANLIGHT_TURNED: true });
  }

  /** Depths of the map that was turned last at this level, mm, top row first; negative: no surface, or not known. */
  turnedDepths(level: number): { size: Size; depthsMm: Float32Array } | undefined {
    const here = this.levels.get(level);
    if (!here || !this.turns) return undefined;
    const { gl } = this;
    const { frame, size } = here.turned;
    const values = new Float32Array(4 * size.width * size.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.readPixels(0, 0, size.width, size.height, gl.RGBA, gl.FLOAT, values);
    return { size, depthsMm: values.filter((_, index) => index % 4 === 0) };
  }

  private levelOf(level: number, { width, height }: Size): LightLevel {
    let here = this.levels.get(level);
    if (here?.size.width === width && here.size.height === height) return here;
    here?.free();
    here = new LightLevel(this.gl, { width, height });
    this.levels.set(level, here);
    return here;
  }

  private turn(level: LightLevel, casts: readonly Cast[], view: View, startMm: number): void {
    const { gl } = this;
    const { frame, size } = level.turned;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.viewport(0, 0, size.width, size.height);
    gl.clearBufferfv(gl.COLOR, 0, [kNoSurface, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE); // the back of a surface is not known
    const program = this.program("turn", turnFragmentShader, {}, turnVertexShader);
    for (const [index, { map, view: from }] of casts.entries()) {
      const values = {
        depth_unit: map.unitMm,
        from_centre: [from.middleColumn, from.middleRow],
        from_pixel: from.mmPerPixel,
        from_pixel_per_mm: from.mmPerPixelPerMm,
        turn: turnBetween(from, view),
        to_centre: [view.middleColumn, view.middleRow],
        to_pixel: view.mmPerPixel,
        to_pixel_per_mm: view.mmPerPixelPerMm,
        to_size: [size.width, size.height],
        start: startMm,
        behind: index === 0 ? 0 : kBehindMm,
      };
      const pixelMm = from.mmPerPixel + from.mmPerPixelPerMm * map.nearestMm;
      const { surfaceIndices, holeIndices } = this.maps.meshOf(map, kSteepest * pixelMm);
      const textures = { ...this.maps.texturesOf(map) };
      program.use({ ...values, holes: 0 }, textures);
      gl.drawElements(gl.TRIANGLES, surfaceIndices, gl.UNSIGNED_INT, 0);
      program.use({ ...values, holes: 1 }, textures);
      gl.drawElements(gl.TRIANGLES, holeIndices, gl.UNSIGNED_INT, 4 * surfaceIndices);
    }
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
  }

  /** `surface`: the textures of the map; `constants`: how the shaders read it. */
  private light(
    level: LightLevel,
    plan: LightPlan,
    values: Uniforms,
    surface: Record<string, WebGLTexture>,
    constants: Constants,
  ): void {
    const all = { ...constantsOf(plan), ...constants };
    const key = JSON.stringify([all, ...kPreparedBy.split(" ").map((name) => plan.parameters[name])]);
    if (key !== level.preparedFor) {
      level.preparedFor = key;
      this.run(this.program("prepare", prepareShader, all), values, surface, level.normals);
      if (plan.softLight) this.run(this.program("prepare_soft", prepareSoftShader, all), values, surface, level.places);
    }
    const textures = { ...surface, normals: level.normals.texture };
    if (plan.softLight) {
      const places = { ...textures, places: level.places.texture };
      this.run(this.program("soft_light", softLightShader, all), values, places, level.soft);
      if (plan.scatters) this.scatter(level, plan, values);
    }
    const light = this.program("light", lightShader, { ...all, kSoftLight: plan.softLight });
    const soft = { soft_direct: level.direct.texture, soft_scattered: level.scattered.texture };
    this.run(light, values, { ...textures, ...soft }, level.lit[0]);
    this.finish(level, plan, values, surface, constants);
  }

  private scatter({ scattered, spread }: LightLevel, plan: LightPlan, values: Uniforms): void {
    const { kPerspective } = constantsOf(plan);
    const rows = this.program("scatter", scatterShader, { kColumns: false, kPerspective });
    const columns = this.program("scatter", scatterShader, { kColumns: true, kPerspective });
    this.run(rows, values, { soft_scattered: scattered.texture }, spread);
    this.run(columns, values, { soft_scattered: spread.texture }, scattered);
  }

  private finish(
    level: LightLevel,
    plan: LightPlan,
    values: Uniforms,
    surface: Record<string, WebGLTexture>,
    constants: Constants,
  ): void {
    let [from, to] = level.lit;
    if (plan.outlines) {
      const textures = { ...surface, lit_picture: from.texture };
      this.run(this.program("outline", outlineShader, constants), values, textures, to);
      [from, to] = [to, from];
    }
    for (let step = 0; step < plan.diffusionSteps; ++step) {
      this.run(this.program("diffuse", diffuseShader), values, { lit_picture: from.texture }, to);
      [from, to] = [to, from];
    }
    const { width, height } = level.size;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.run(this.program("finish", finishShader), values, { lit_picture: from.texture }, level.size);
  }

  /** Draws to the target, or to the canvas of that size. */
  private run(program: Program, values: Uniforms, textures: Record<string, WebGLTexture>, to: Frame | Size): void {
    const { gl } = this;
    const [frame, size] = "frame" in to ? [to.frame, to.size] : [null, to];
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.viewport(0, 0, size.width, size.height);
    program.use(values, textures);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private program(name: string, shader: string, constants: Constants = {}, vertexShader = pictureShader): Program {
    const key = name + JSON.stringify(constants);
    const known = this.programs.get(key);
    if (known) return known;
    const made = new Program(this.gl, vertexShader, shader, constants);
    this.programs.set(key, made);
    return made;
  }
}

function constantsOf(plan: LightPlan): { kPerspective: boolean; kSoftShadows: boolean } {
  return { kPerspective: plan.perspective, kSoftShadows: plan.softShadows };
}

function uniformsOf(plan: LightPlan, more: Uniforms): Uniforms {
  const parameters = Object.entries(plan.parameters).map(([name, value]) => [`lighting.${name}`, value] as const);
  return { ...Object.fromEntries(parameters), ...more };
}
