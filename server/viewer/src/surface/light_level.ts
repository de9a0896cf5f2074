// SPDX-License-Identifier: Apache-2.0
// The memory that lighting a picture of one size needs.
import { newTexture } from "./map_textures";
import type { DepthMap } from "./surface_decoder";

export interface Size {
  width: number;
  height: number;
}

export interface Frame {
  frame: WebGLFramebuffer;
  size: Size;
}

export interface Target extends Frame {
  texture: WebGLTexture;
}

export class LightLevel {
  /** What is prepared of a depth map, of pixels and of 2 x 2 pixels. */
  readonly normals: Target;
  readonly places: Target;
  readonly lit: readonly [Target, Target];
  /** Maps of soft light: direct and sky; scattered and depth, and the same half spread; a frame of the first two. */
  readonly direct: Target;
  readonly scattered: Target;
  readonly spread: Target;
  readonly soft: Frame;
  /** The map, where it is one that was received, and the settings that the prepared maps were made of. */
  preparedOf: DepthMap | undefined;
  preparedFor = "";
  private depthBuffer: WebGLRenderbuffer | null = null;
  private turnedMap: Target | undefined;

  constructor(
    private readonly gl: WebGL2RenderingContext,
    readonly size: Size,
  ) {
    const half = { width: (size.width + 1) >> 1, height: (size.height + 1) >> 1 };
    this.normals = this.newTarget(size);
    this.places = this.newTarget(half);
    this.lit = [this.newTarget(size), this.newTarget(size)];
    this.direct = this.newTarget(half);
    this.scattered = this.newTarget(half);
    this.spread = this.newTarget(half);
    this.soft = this.frameOf(this.direct, this.scattered);
  }

  /** A depth map in full floats, with a depth buffer. */
  get turned(): Target {
    if (this.turnedMap) return this.turnedMap;
    const { gl, size } = this;
    const made = this.newTarget(size, { format: gl.RG32F, components: gl.RG, type: gl.FLOAT });
    this.depthBuffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, this.depthBuffer);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, size.width, size.height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depthBuffer);
    return (this.turnedMap = made);
  }

  free(): void {
    this.gl.deleteRenderbuffer(this.depthBuffer);
    this.gl.deleteFramebuffer(this.soft.frame);
    const soft = [this.direct, this.scattered, this.spread];
    for (const target of [this.normals, this.places, ...this.lit, ...soft, this.turnedMap]) {
      if (!target) continue;
      this.gl.deleteTexture(target.texture);
      this.gl.deleteFramebuffer(target.frame);
    }
  }

  private frameOf(...targets: readonly Target[]): Frame {
    const { gl } = this;
    const frame = gl.createFramebuffer()!;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const places = targets.map((_, index) => gl.COLOR_ATTACHMENT0 + index);
    for (const [index, { texture }] of targets.entries())
      gl.framebufferTexture2D(gl.FRAMEBUFFER, places[index]!, gl.TEXTURE_2D, texture, 0);
    gl.drawBuffers(places);
    return { frame, size: targets[0]!.size };
  }

  private newTarget(
    size: Size,
    kind = {
      format: this.gl.RGBA16F as number,
      components: this.gl.RGBA as number,
      type: this.gl.HALF_FLOAT as number,
    },
  ): Target {
    const { gl } = this;
    const made = { texture: newTexture(gl), frame: gl.createFramebuffer()!, size };
    gl.texImage2D(gl.TEXTURE_2D, 0, kind.format, size.width, size.height, 0, kind.components, kind.type, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, made.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made.texture, 0);
    return made;
  }
}
