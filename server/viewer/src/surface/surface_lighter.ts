// SPDX-License-Identifier: Apache-2.0
// Passes 2 and 3 of the renderer from the light on, by WebGL 2: shades a depth map that the server has filtered. The
// formulas are those of the server, in the same text (shaders/web). What does not depend on the light is prepared once.
import diffuseShader from "diffuse.frag";
import finishShader from "finish.frag";
import lightShader from "light.frag";
import pictureShader from "picture.vert";
import prepareShader from "prepare.frag";
import prepareSoftShader from "prepare_soft.frag";
import scatterShader from "scatter.frag";
import softLightShader from "soft_light.frag";
import { LightLevel, type Size, type Target } from "./light_level";
import type { LightPlan } from "./light_parameters";
import { Program, type Constants, type Uniforms } from "./program";
import type { DepthMap } from "./surface_decoder";

const kDeepestMm = 1e9; // FANLIGHT_MAX_DEPTH
// Members of the parameters that the prepared maps depend on.
const kPreparedBy =
  "centre pixel view_scale_at_0 view_scale_per_mm same_surface central_normals occlusion occlusion_reach fade_reach";

export class SurfaceLighter {
  readonly canvas = document.createElement("canvas");
  private readonly gl: WebGL2RenderingContext;
  private readonly programs = new Map<string, Program>();
  private readonly levels = new Map<number, LightLevel>();

  /** Throws where the browser has no WebGL 2 that draws to half floats. */
  constructor() {
    const gl = this.canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false });
    if (!gl) throw new Error("This browser has no WebGL 2.");
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new Error("This browser's WebGL draws no half floats.");
    this.gl = gl;
  }

  /** Whether the browser has taken the GPU away; it may come back with a new object. */
  get isLost(): boolean {
    return this.gl.isContextLost();
  }

  /** Draws to `canvas`. Maps of one `level` have one size, mostly: its memory is used again. */
  draw(level: number, map: DepthMap, plan: LightPlan): void {
    const here = this.levels.get(level) ?? new LightLevel(this.gl);
    this.levels.set(level, here);
    here.take(map);
    const parameters = Object.entries(plan.parameters).map(([name, value]) => [`lighting.${name}`, value] as const);
    const values: Uniforms = {
      ...Object.fromEntries(parameters),
      depth_unit: map.unitMm,
      nearest: Math.min(map.nearestMm, kDeepestMm),
    };
    this.prepare(here, plan, values);
    if (plan.softLight) this.lightSoftly(here, plan, values);
    const { kPerspective, kSoftShadows } = constantsOf(plan);
    const textures = { depths: here.depths, normals: here.normals.texture, soft_lights: here.soft[0].texture };
    const light = this.program("light", lightShader, { kPerspective, kSoftShadows, kSoftLight: plan.softLight });
    this.run(light, values, textures, here.lit[0]);
    this.finish(here, plan, values);
  }

  private prepare(level: LightLevel, plan: LightPlan, values: Uniforms): void {
    const { parameters, softLight, perspective } = plan;
    const key = JSON.stringify([softLight, perspective, ...kPreparedBy.split(" ").map((name) => parameters[name])]);
    if (key === level.preparedFor) return;
    level.preparedFor = key;
    const textures = { depths: level.depths, certainties: level.certainties };
    const constants = constantsOf(plan);
    this.run(this.program("prepare", prepareShader, constants), values, textures, level.normals);
    if (softLight) this.run(this.program("prepare_soft", prepareSoftShader, constants), values, textures, level.places);
  }

  private lightSoftly(level: LightLevel, plan: LightPlan, values: Uniforms): void {
    const [soft, spread] = level.soft;
    const textures = { depths: level.depths, normals: level.normals.texture, places: level.places.texture };
    this.run(this.program("soft_light", softLightShader, constantsOf(plan)), values, textures, soft);
    if (!plan.scatters) return;
    const { kPerspective } = constantsOf(plan);
    const rows = this.program("scatter", scatterShader, { kColumns: false, kPerspective });
    const columns = this.program("scatter", scatterShader, { kColumns: true, kPerspective });
    this.run(rows, values, { soft_lights: soft.texture }, spread);
    this.run(columns, values, { soft_lights: spread.texture }, soft);
  }

  private finish(level: LightLevel, plan: LightPlan, values: Uniforms): void {
    let [from, to] = level.lit;
    for (let step = 0; step < plan.diffusionSteps; ++step) {
      this.run(this.program("diffuse", diffuseShader), values, { lit_picture: from.texture }, to);
      [from, to] = [to, from];
    }
    const { width, height } = level.size;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.run(this.program("finish", finishShader), values, { lit_picture: from.texture }, level.size);
  }

  /** Draws to the target, or to the canvas of that size. */
  private run(program: Program, values: Uniforms, textures: Record<string, WebGLTexture>, to: Target | Size): void {
    const { gl } = this;
    const [frame, size] = "frame" in to ? [to.frame, to.size] : [null, to];
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.viewport(0, 0, size.width, size.height);
    program.use(values, textures);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private program(name: string, shader: string, constants: Constants = {}): Program {
    const key = name + JSON.stringify(constants);
    const known = this.programs.get(key);
    if (known) return known;
    const made = new Program(this.gl, pictureShader, shader, constants);
    this.programs.set(key, made);
    return made;
  }
}

function constantsOf(plan: LightPlan): { kPerspective: boolean; kSoftShadows: boolean } {
  return { kPerspective: plan.perspective, kSoftShadows: plan.softShadows };
}
