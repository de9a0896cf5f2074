// SPDX-License-Identifier: Apache-2.0
// A program of WebGL 2 from a shader of the renderer: its constants, uniforms by name, textures by name.

/** Specialisation constants of the shader, by name; FANLIGHT_... are defined if true. */
export type Constants = Readonly<Record<string, boolean>>;
export type Uniforms = Readonly<Record<string, number | readonly number[]>>;

export class Program {
  private readonly program: WebGLProgram;
  private readonly uniforms: { name: string; type: number; at: WebGLUniformLocation }[] = [];

  /** Throws with the compiler's sentence. */
  constructor(
    private readonly gl: WebGL2RenderingContext,
    vertexShader: string,
    fragmentShader: string,
    constants: Constants = {},
  ) {
    const declared = Object.entries(constants).map(([name, value]) => {
      if (name.startsWith("FANLIGHT_")) return value ? `#define ${name}\n` : "";
      return `const bool ${name} = ${value};\n`;
    });
    const head = `#version 300 es\nprecision highp float;\nprecision highp int;\n#define FANLIGHT_WEB\n${declared.join("")}`;
    this.program = gl.createProgram()!;
    for (const [type, text] of [
      [gl.VERTEX_SHADER, vertexShader],
      [gl.FRAGMENT_SHADER, fragmentShader],
    ] as const) {
      const shader = gl.createShader(type)!;
      gl.shaderSource(shader, head + text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
        throw new Error(`A shader could not be compiled: ${gl.getShaderInfoLog(shader)}`);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(`The shaders could not be linked: ${gl.getProgramInfoLog(this.program)}`);
    const count = Number(gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS) ?? 0);
    for (let index = 0; index < count; ++index) {
      const uniform = gl.getActiveUniform(this.program, index);
      const at = uniform && gl.getUniformLocation(this.program, uniform.name);
      if (uniform && at) this.uniforms.push({ name: uniform.name.replace("[0]", ""), type: uniform.type, at });
    }
  }

  /** Makes the program current, with these values; a uniform that is not named is 0. */
  use(values: Uniforms, textures: Readonly<Record<string, WebGLTexture>>): void {
    const { gl } = this;
    gl.useProgram(this.program);
    let unit = 0;
    for (const { name, type, at } of this.uniforms) {
      const texture = textures[name];
      if (texture) {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.uniform1i(at, unit++);
      } else {
        this.set(type, at, values[name] ?? 0);
      }
    }
    gl.activeTexture(gl.TEXTURE0);
  }

  private set(type: number, at: WebGLUniformLocation, value: number | readonly number[]): void {
    const { gl } = this;
    const vector = (size: number) => (typeof value === "number" ? Array<number>(size).fill(value) : value);
    if (type === gl.FLOAT) gl.uniform1f(at, Number(value));
    else if (type === gl.INT) gl.uniform1i(at, Number(value));
    else if (type === gl.UNSIGNED_INT) gl.uniform1ui(at, Number(value));
    else if (type === gl.FLOAT_VEC2) gl.uniform2fv(at, vector(2));
    else if (type === gl.FLOAT_VEC3) gl.uniform3fv(at, vector(3));
    else if (type === gl.FLOAT_VEC4) gl.uniform4fv(at, vector(4));
    else if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(at, false, vector(16));
    else throw new Error(`A uniform has the type ${type}, which is not known here.`);
  }
}
