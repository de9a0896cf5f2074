// SPDX-License-Identifier: Apache-2.0
// Depth maps in the GPU's memory. The least recently used ones make room for new ones.
import type { DepthMap } from "./surface_decoder";
import { meshOf } from "./surface_mesh";

export interface MapTextures {
  depths: WebGLTexture;
  certainties: WebGLTexture;
}

/** See SurfaceMesh. */
export interface MapMesh {
  buffer: WebGLBuffer;
  surfaceIndices: number;
  holeIndices: number;
}

interface Kept {
  textures: MapTextures;
  mesh?: MapMesh;
}

/** Maps of the kept casts, at the full size and at a coarser one. */
const kMostMaps = 8;

export class MapStore {
  private readonly kept = new Map<DepthMap, Kept>(); // the last one used is the last

  constructor(private readonly gl: WebGL2RenderingContext) {}

  texturesOf(map: DepthMap): MapTextures {
    return this.keptOf(map).textures;
  }

  /** Its buffer is bound. `largestStepMm`: as for meshOf(); always the same for a map. */
  meshOf(map: DepthMap, largestStepMm: number): MapMesh {
    const { gl } = this;
    const kept = this.keptOf(map);
    if (!kept.mesh) {
      const { indices, surfaceIndices } = meshOf(map, largestStepMm);
      const buffer = gl.createBuffer()!;
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
      kept.mesh = { buffer, surfaceIndices, holeIndices: indices.length - surfaceIndices };
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, kept.mesh.buffer);
    return kept.mesh;
  }

  private keptOf(map: DepthMap): Kept {
    const here = this.kept.get(map) ?? { textures: this.made(map) };
    this.kept.delete(map);
    this.kept.set(map, here);
    const [oldest, old] = [...this.kept][0]!;
    if (this.kept.size > kMostMaps) {
      this.kept.delete(oldest);
      for (const texture of [old.textures.depths, old.textures.certainties]) this.gl.deleteTexture(texture);
      if (old.mesh) this.gl.deleteBuffer(old.mesh.buffer);
    }
    return here;
  }

  private made({ width, height, depths, certainties }: DepthMap): MapTextures {
    const { gl } = this;
    const put = (format: number, type: number, values: ArrayBufferView) => {
      const texture = newTexture(gl);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RED_INTEGER, type, values);
      return texture;
    };
    return {
      depths: put(gl.R16UI, gl.UNSIGNED_SHORT, depths),
      certainties: put(gl.R8UI, gl.UNSIGNED_BYTE, certainties),
    };
  }
}

/** A texture that is read pixel by pixel; bound. */
export function newTexture(gl: WebGL2RenderingContext): WebGLTexture {
  const texture = gl.createTexture()!;
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
  for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
  return texture;
}
