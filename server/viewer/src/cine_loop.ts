// SPDX-License-Identifier: Apache-2.0
// Plays the volumes of the cine that this display has kept, at the rate at which they were captured, whatever the rate
// at which the server draws them. The rules are those of renderer/schedule/cine_player.
import { CineStatus_State as State, type CineStatus } from "../generated/fanlight_pb.js";

/** A gap between two volumes, such as a pause of the source, is not waited for. */
const kMostMs = 1000;
const kLeastMs = 10;
/** So long the last volume is on show where all have one capture time. */
const kUsualS = 0.1;

export interface CineVolume {
  volumeId: bigint;
  timeS: number; // since the oldest one
}

export interface Clock {
  nowMs(): number;
  /** Runs something later, once; in place of what was to run. Absent: nothing. */
  runIn(ms: number, run?: () => void): void;
}

/** The page's. */
function pageClock(): Clock {
  let timer = 0;
  return {
    nowMs: () => performance.now(),
    runIn: (ms, run) => {
      window.clearTimeout(timer);
      if (run) timer = window.setTimeout(run, ms);
    },
  };
}

export class CineLoop {
  private readonly volumes: CineVolume[] = []; // by their number, as far as they were on show
  private count = 0;
  private durationS = 0;
  private speed = 1;
  private at: number | undefined; // the number of the volume on show; undefined: it does not play
  private sinceMs = 0;

  constructor(
    private readonly kept: {
      has(volumeId: bigint): boolean;
      /** Whether it could. */
      show(volumeId: bigint): boolean;
    },
    private readonly clock = pageClock(),
  ) {}

  /** The number of the volume on show; undefined while it does not play. */
  get volume(): number | undefined {
    return this.at;
  }

  /** The volume of that number, if it was on show before. */
  of(volume: number): CineVolume | undefined {
    return this.volumes[volume];
  }

  /** The number of a volume that the server has shown; undefined for others. */
  numberOf(volumeId: bigint): number | undefined {
    const number = this.volumes.findIndex((each) => each?.volumeId === volumeId);
    return number < 0 ? undefined : number;
  }

  /** Learns from the server which volumes there are. Plays while the server does and this display has them all. */
  tell({ state, volumes, volume, volumeId, timeS, durationS, speed }: CineStatus): void {
    const known = this.volumes[volume];
    const isOther = volumes !== this.count || durationS !== this.durationS || (known && known.volumeId !== volumeId);
    if (state === State.LIVE || isOther) this.forget();
    [this.count, this.durationS] = [volumes, durationS];
    if (state === State.LIVE) return;
    this.volumes[volume] = { volumeId, timeS };
    if (this.speed !== speed) this.sinceMs = this.clock.nowMs();
    const isQuicker = speed > this.speed;
    this.speed = speed;
    if (isQuicker && this.at !== undefined) this.wait();
    if (state !== State.PLAYING) return this.stop();
    if (this.at === undefined && this.isKnown) this.start(volume);
  }

  forget(): void {
    this.stop();
    this.volumes.length = 0;
  }

  stop(): void {
    this.clock.runIn(0);
    this.at = undefined;
  }

  private get isKnown(): boolean {
    const all = Array.from({ length: this.count }, (_, volume) => this.volumes[volume]);
    return all.length > 1 && all.every((each) => each !== undefined && this.kept.has(each.volumeId));
  }

  private start(volume: number): void {
    this.at = volume;
    this.sinceMs = this.clock.nowMs();
    this.showAt();
  }

  private showAt(): void {
    if (!this.kept.show(this.volumes[this.at!]!.volumeId)) return this.stop();
    this.wait();
  }

  private wait(): void {
    this.clock.runIn(this.sinceMs + this.shownMs() - this.clock.nowMs(), () => this.advance());
  }

  private advance(): void {
    // At most one round: a page that was held up for longer continues from where it is.
    for (let step = 0; step < this.count; ++step) {
      const untilMs = this.sinceMs + this.shownMs();
      if (untilMs > this.clock.nowMs()) return step > 0 ? this.showAt() : this.wait(); // it is slower now
      this.sinceMs = untilMs;
      this.at = (this.at! + 1) % this.count;
    }
    this.sinceMs = this.clock.nowMs();
    this.showAt();
  }

  private shownMs(): number {
    const next = this.volumes[this.at! + 1];
    const meanS = this.durationS > 0 ? this.durationS / (this.count - 1) : kUsualS;
    const s = next ? next.timeS - this.volumes[this.at!]!.timeS : meanS;
    return Math.max(kLeastMs, Math.min(kMostMs, 1000 * s) / this.speed);
  }
}
