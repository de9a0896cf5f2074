// SPDX-License-Identifier: Apache-2.0
// A depth map on the GPU at one resolution, with the memory that lighting it needs.
import type { DepthMap } from "./surface_decoder";

export interface Size {
  width: number;
  height: number;
}

export interface Target {
  texture: WebGLTexture;
  frame: WebGLFramebuffer;
  size: Size;
}

export class LightLevel {
  readonly size: Size = { width: 0, height: 0 };
  depths!: WebGLTexture;
  certainties!: WebGLTexture;
  /** What is prepared of the map, of pixels and of 2 x 2 pixels. */
  normals!: Target;
  places!: Target;
  /** Two pictures, and two maps of soft light. */
  lit!: [Target, Target];
  soft!: [Target, Target];
  map: DepthMap | undefined;
  /** Of the settings that the prepared maps are made with. */
  preparedFor = "";

  constructor(private readonly gl: WebGL2RenderingContext) {}

  take(map: DepthMap): void {
    if (map === this.map) return;
    const { gl } = this;
    if (map.width !== this.size.width || map.height !== this.size.height) this.resize(map.width, map.height);
    this.map = map;
    this.preparedFor = "";
    const put = (texture: WebGLTexture, format: number, type: number, values: ArrayBufferView) => {
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texImage2D(gl.TEXTURE_2D, 0, format, map.width, map.height, 0, gl.RED_INTEGER, type, values);
    };
    put(this.depths, gl.R16UI, gl.UNSIGNED_SHORT, map.depths);
    put(this.certainties, gl.R8UI, gl.UNSIGNED_BYTE, map.certainties);
  }

  private resize(width: number, height: number): void {
    this.free();
    Object.assign(this.size, { width, height });
    const half = { width: (width + 1) >> 1, height: (height + 1) >> 1 };
    this.depths = this.newTexture();
    this.certainties = this.newTexture();
    this.normals = this.newTarget(this.size);
    this.places = this.newTarget(half);
    this.lit = [this.newTarget(this.size), this.newTarget(this.size)];
    this.soft = [this.newTarget(half), this.newTarget(half)];
  }

  private free(): void {
    if (this.size.width === 0) return;
    for (const { texture, frame } of [this.normals, this.places, ...this.lit, ...this.soft]) {
      this.gl.deleteTexture(texture);
      this.gl.deleteFramebuffer(frame);
    }
    for (const texture of [this.depths, this.certainties]) this.gl.deleteTexture(texture);
  }

  private newTexture(): WebGLTexture {
    const { gl } = this;
    const texture = gl.createTexture()!;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    return texture;
  }

  private newTarget(size: Size): Target {
    const { gl } = this;
    const made = { texture: this.newTexture(), frame: gl.createFramebuffer()!, size: { ...size } };
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, size.width, size.height, 0, gl.RGBA, gl.HALF_FLOAT, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, made.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made.texture, 0);
    return made;
  }
}
