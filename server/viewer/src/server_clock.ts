// The server's steady clock, told by the page's own.

const kSamples = 60;

/** Takes the offset of the sample with the shortest round trip among the last kSamples. */
export class ServerClock {
  private samples: { roundTripMs: number; offsetMs: number }[] = [];

  /** `sentMs` and `receivedMs` are the page's performance.now(). */
  add(sentMs: number, serverTimeNs: bigint, receivedMs: number): void {
    const roundTripMs = receivedMs - sentMs;
    this.samples.push({ roundTripMs, offsetMs: Number(serverTimeNs) / 1e6 - (sentMs + receivedMs) / 2 });
    if (this.samples.length > kSamples) this.samples.shift();
  }

  /** A server that was started again has another clock. */
  reset(): void {
    this.samples = [];
  }

  /** Milliseconds of the server's clock at `pageMs`, or undefined before the first reply. */
  at(pageMs: number): number | undefined {
    const best = this.samples.reduce<(typeof this.samples)[number] | undefined>(
      (least, sample) => (least && least.roundTripMs <= sample.roundTripMs ? least : sample),
      undefined,
    );
    return best && pageMs + best.offsetMs;
  }
}
