// How many pictures a second were shown, and how old they were.

const kRateWindowMs = 2000;
const kAgeWindowMs = 1000;

/** Times are the page's performance.now(), except where they say that they are the server's. */
export class PicturePace {
  private shown: { atMs: number; capturedServerMs: number }[] = [];

  /** `serverMs` turns a time of the page into the server's, or tells that it cannot yet. */
  constructor(private readonly serverMs: (pageMs: number) => number | undefined) {}

  add(atMs: number, capturedServerMs: number): void {
    this.shown.push({ atMs, capturedServerMs });
    // And the one before: of a stream slower than the window two pictures make the rate.
    const recent = this.shown.filter((picture) => atMs - picture.atMs <= kRateWindowMs).length;
    this.shown = this.shown.slice(-Math.max(recent, 2));
  }

  reset(): void {
    this.shown = [];
  }

  /**
   * Over the last two seconds, or the last two pictures; from the distances of the pictures, so that slow streams do
   * not flicker. 0 once the next picture is twice as late as that.
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

  /** The median when shown over the last second; of a picture that stands longer, its age by now. */
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
