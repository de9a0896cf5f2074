// SPDX-License-Identifier: Apache-2.0
// Points of the surface that the server has rendered, for a display that does not know them itself.
import type { DepthReply } from "../generated/fanlight_pb.js";
import type { Mm } from "./measurement";
import type { PagePoint } from "./view_geometry";

type Points = (Mm | undefined)[];

export class SurfacePoints {
  private lastId = 1n << 32n; // of these requests; others count from 1
  private readonly waiting = new Map<bigint, (points: Points) => void>();

  constructor(private readonly ask: (requestId: bigint, pixels: PagePoint[]) => void) {}

  /** Undefined where there is no surface. */
  at(pixels: PagePoint[]): Promise<Points> {
    return new Promise((resolve) => {
      this.waiting.clear(); // what a lost connection has left
      this.waiting.set((this.lastId += 1n), resolve);
      this.ask(this.lastId, pixels);
    });
  }

  answered({ requestId, points }: DepthReply): void {
    const resolve = this.waiting.get(requestId);
    this.waiting.delete(requestId);
    resolve?.(points.map(({ surface, xMm, yMm, zMm }) => (surface ? [xMm, yMm, zMm] : undefined)));
  }
}
