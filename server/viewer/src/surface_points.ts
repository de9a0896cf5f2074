// SPDX-License-Identifier: Apache-2.0
// Points of the surface that the server has rendered, for a display that does not know them itself.
import type { DepthReply } from "../generated/fanlight_pb.js";
import type { Mm } from "./measuring/figures";
import type { PagePoint } from "./view_geometry";

/** Undefined where there is no surface. */
export type SurfaceAnswer = (Mm | undefined)[];

const kMostWaiting = 32;

export class SurfacePoints {
  private lastId = 1n << 32n; // of these requests; others count from 1
  private readonly waiting = new Map<bigint, (points: SurfaceAnswer | undefined) => void>();

  constructor(private readonly ask: (requestId: bigint, pixels: PagePoint[]) => void) {}

  /** Undefined where the server does not answer. */
  at(pixels: PagePoint[]): Promise<SurfaceAnswer | undefined> {
    return new Promise((resolve) => {
      for (const id of [...this.waiting.keys()].slice(0, -kMostWaiting)) this.settle(id, undefined);
      this.waiting.set((this.lastId += 1n), resolve);
      this.ask(this.lastId, pixels);
    });
  }

  answered({ requestId, points, refused }: DepthReply): void {
    const answer = points.map(({ surface, xMm, yMm, zMm }): Mm | undefined => (surface ? [xMm, yMm, zMm] : undefined));
    this.settle(requestId, refused ? undefined : answer);
  }

  /** Call at the start of a session: what was asked before is not answered any more. */
  forget(): void {
    for (const id of [...this.waiting.keys()]) this.settle(id, undefined);
  }

  private settle(id: bigint, answer: SurfaceAnswer | undefined): void {
    const resolve = this.waiting.get(id);
    this.waiting.delete(id);
    resolve?.(answer);
  }
}
