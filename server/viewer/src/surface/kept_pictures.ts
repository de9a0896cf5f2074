// SPDX-License-Identifier: Apache-2.0
// Pictures that were shown, with their depth maps: a step through frozen volumes finds those that it has seen before.
import type { Picture } from "../../generated/fanlight_pb.js";
import type { DepthMap } from "./surface_decoder";

export interface KeptPicture {
  /** Without the packed surface. */
  picture: Picture;
  map: DepthMap;
  /** Of the settings that the depth map depends on, but for the camera. */
  castKey: string;
}

const kMostBytes = 64e6;

export class KeptPictures {
  private readonly kept = new Map<bigint, KeptPicture>(); // by volume; the one kept last is the last
  private bytes = 0;

  constructor(private readonly mostBytes = kMostBytes) {}

  add(picture: KeptPicture): void {
    this.drop(picture.picture.volumeId);
    this.kept.set(picture.picture.volumeId, picture);
    this.bytes += bytesOf(picture);
    for (const id of this.kept.keys()) if (this.bytes > this.mostBytes && this.kept.size > 1) this.drop(id);
  }

  of(volumeId: bigint): KeptPicture | undefined {
    return this.kept.get(volumeId);
  }

  clear(): void {
    this.kept.clear();
    this.bytes = 0;
  }

  private drop(volumeId: bigint): void {
    const old = this.kept.get(volumeId);
    if (!old) return;
    this.kept.delete(volumeId);
    this.bytes -= bytesOf(old);
  }
}

function bytesOf({ map }: KeptPicture): number {
  return map.depths.byteLength + map.certainties.byteLength;
}
