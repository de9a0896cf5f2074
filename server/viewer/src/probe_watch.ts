// Whether the probe is there, and whether the picture shown is of what it sees now.
import { ProbeStatus_State } from "../generated/fanlight_pb.js";

const kBackMs = 5000; // long enough to be read

/** What there is to say about the probe. */
export type ProbeNews =
  | { state: "lost"; since: LostSince | undefined }
  /** Without a picture of the time after its return it has just been found. */
  | { state: "back"; pictureShown: boolean };

/** On the wall's clock. Who came later only knows when the last volume ended, which was before. */
export interface LostSince {
  wallMs: number;
  seen: boolean;
}

/** Times are the page's performance.now(), except where they say whose they are. */
export class ProbeWatch {
  private state: ProbeStatus_State = ProbeStatus_State.ABSENT;
  private since: LostSince | undefined;
  private returnedMs: number | undefined;
  private capturedServerMs: number | undefined;

  /** `serverMs` turns a time of the page into the server's, or tells that it cannot yet; `wallMs` into the wall's. */
  constructor(
    private readonly serverMs: (pageMs: number) => number | undefined,
    private readonly wallMs: (pageMs: number) => number,
  ) {}

  /** A session begins. */
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

  /** A picture is shown. */
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
   * After a return only a volume that ended since will do: the last one before the loss is drawn again whenever the
   * scene changes, and may have been on its way.
   */
  isLive(): boolean {
    if (this.state === ProbeStatus_State.LOST) return false;
    if (this.returnedMs === undefined) return true;
    const returnedServerMs = this.serverMs(this.returnedMs);
    if (returnedServerMs === undefined || this.capturedServerMs === undefined) return false;
    return this.capturedServerMs > returnedServerMs;
  }

  /** Of the picture shown; undefined without one, and before the server's clock is known. */
  ageMs(nowMs: number): number | undefined {
    const serverMs = this.serverMs(nowMs);
    return serverMs === undefined || this.capturedServerMs === undefined
      ? undefined
      : Math.max(0, serverMs - this.capturedServerMs);
  }

  /** Kept once it is known, so that it does not move with the clocks' comparison. */
  private lostSince(nowMs: number): LostSince | undefined {
    const ageMs = this.ageMs(nowMs);
    if (ageMs !== undefined) this.since ??= { wallMs: this.wallMs(nowMs) - ageMs, seen: false };
    return this.since;
  }
}
