// SPDX-License-Identifier: Apache-2.0
// Whether the probe is connected, and whether the picture shown is live.
import { ProbeStatus_State } from "../generated/fanlight_pb.js";

const kBackMs = 5000; // long enough to read the notice

/** News about the probe for the notice. */
export type ProbeNews =
  | { state: "lost"; since: LostSince | undefined }
  /** `pictureShown`: whether a volume from after the return is shown. */
  | { state: "back"; pictureShown: boolean };

/** Wall clock. `seen` is false if the loss was before this session; then it is an estimate, the last volume's end. */
export interface LostSince {
  wallMs: number;
  seen: boolean;
}

/** Times are performance.now() of the page, except where the name says another clock. */
export class ProbeWatch {
  private state: ProbeStatus_State = ProbeStatus_State.ABSENT;
  private since: LostSince | undefined;
  private returnedMs: number | undefined;
  private capturedServerMs: number | undefined;

  /** Convert a time of the page: `serverMs` to the server's clock, undefined while unknown; `wallMs` to wall time. */
  constructor(
    private readonly serverMs: (pageMs: number) => number | undefined,
    private readonly wallMs: (pageMs: number) => number,
  ) {}

  /** Call at the start of a session. */
  reset(): void {
    this.state = ProbeStatus_State.ABSENT;
    this.since = this.returnedMs = this.capturedServerMs = undefined;
  }

  tell(state: ProbeStatus_State, nowMs: number): void {
    const { LOST, ABSENT } = ProbeStatus_State;
    if (state === LOST && this.state !== LOST) {
      this.since = this.state === ABSENT ? undefined : { wallMs: this.wallMs(nowMs), seen: true };
    }
    if (state !== LOST && this.state === LOST) this.returnedMs = nowMs;
    this.state = state;
  }

  /** Call for each picture shown. */
  show(capturedServerMs: number): void {
    this.capturedServerMs = capturedServerMs;
  }

  news(nowMs: number): ProbeNews | undefined {
    if (this.state === ProbeStatus_State.LOST) return { state: "lost", since: this.lostSince(nowMs) };
    if (this.returnedMs === undefined) return undefined;
    const pictureShown = this.isLive();
    return pictureShown && nowMs - this.returnedMs >= kBackMs ? undefined : { state: "back", pictureShown };
  }

  /**
   * After a return only a volume that ended later counts as live. The last volume before the loss is drawn again
   * whenever the scene changes, and its picture may have been in flight.
   */
  isLive(): boolean {
    if (this.state === ProbeStatus_State.LOST) return false;
    if (this.returnedMs === undefined) return true;
    const returnedServerMs = this.serverMs(this.returnedMs);
    if (returnedServerMs === undefined || this.capturedServerMs === undefined) return false;
    return this.capturedServerMs > returnedServerMs;
  }

  /** Age of the picture shown; undefined without a picture, or while the server's clock is unknown. */
  ageMs(nowMs: number): number | undefined {
    const serverMs = this.serverMs(nowMs);
    return serverMs === undefined || this.capturedServerMs === undefined
      ? undefined
      : Math.max(0, serverMs - this.capturedServerMs);
  }

  /** Fixed once it is known, so that it does not change with later estimates of the clock offset. */
  private lostSince(nowMs: number): LostSince | undefined {
    const ageMs = this.ageMs(nowMs);
    if (ageMs !== undefined) this.since ??= { wallMs: this.wallMs(nowMs) - ageMs, seen: false };
    return this.since;
  }
}
