// SPDX-License-Identifier: Apache-2.0
// Measures the rate and the age of the pictures shown.

const kRateWindowMs = 2000;
const kAgeWindowMs = 1000;

/** Times are performance.now() of the page; names with `server` are on the clock of the server. */
export class PicturePace {
  private shown: { atMs: number; capturedServerMs: number }[] = [];

  /** `serverMs` converts a time of the page to the server's clock; undefined while that is unknown. */
  constructor(private readonly serverMs: (pageMs: number) => number | undefined) {}

  add(atMs: number, capturedServerMs: number): void {
    this.shown.push({ atMs, capturedServerMs });
    // Keep at least two: a stream slower than the window has its rate from its last two pictures.
    const recent = this.shown.filter((picture) => atMs - picture.atMs <= kRateWindowMs).length;
    this.shown = this.shown.slice(-Math.max(recent, 2));
  }

  reset(): void {
    this.shown = [];
  }

  /**
   * Pictures a second over the last two seconds, or over the last two pictures. Computed from their distances, so that
   * slow streams do not flicker. 0 if the next picture is later than twice that distance (two seconds at least).
   */
  perSecond(nowMs: number): number {
    const within = this.shown.filter((picture) => nowMs - picture.atMs <= kRateWindowMs).length;
    const recent = this.shown.slice(-Math.max(within, 2));
    const first = recent.at(0);
    const last = recent.at(-1);
    if (!first || !last || last.atMs === first.atMs) return 0;
    const apartMs = (last.atMs - first.atMs) / (recent.length - 1);
    return nowMs - last.atMs > Math.max(kRateWindowMs, 2 * apartMs) ? 0 : 1000 / apartMs;
  }

  /** Median age when shown, over the last second; the present age of the last picture if none came in that second. */
  ageMs(nowMs: number): number | undefined {
    const recent = this.shown.filter((picture) => nowMs - picture.atMs <= kAgeWindowMs);
    if (recent.length === 0) {
      const last = this.shown.at(-1);
      return last && this.age(last.capturedServerMs, nowMs);
    }
    const ages = recent.flatMap(({ atMs, capturedServerMs }) => this.age(capturedServerMs, atMs) ?? []);
    return ages.sort((a, b) => a - b)[Math.floor(ages.length / 2)];
  }

  private age(capturedServerMs: number, atMs: number): number | undefined {
    const serverMs = this.serverMs(atMs);
    return serverMs === undefined ? undefined : serverMs - capturedServerMs;
  }
}
