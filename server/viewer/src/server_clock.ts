// SPDX-License-Identifier: Apache-2.0
// Estimates the server's steady clock from the clock of the page.

const kSamples = 60;

/** Uses the offset of the sample with the shortest round trip among the last kSamples. */
export class ServerClock {
  private samples: { roundTripMs: number; offsetMs: number }[] = [];

  /** `sentMs` and `receivedMs` are performance.now() of the page. */
  add(sentMs: number, serverTimeNs: bigint, receivedMs: number): void {
    const roundTripMs = receivedMs - sentMs;
    this.samples.push({ roundTripMs, offsetMs: Number(serverTimeNs) / 1e6 - (sentMs + receivedMs) / 2 });
    if (this.samples.length > kSamples) this.samples.shift();
  }

  /** Forgets all samples: a restarted server has another clock. */
  reset(): void {
    this.samples = [];
  }

  /** The server's clock at `pageMs`, in ms; undefined before the first reply. */
  at(pageMs: number): number | undefined {
    const best = this.samples.reduce<(typeof this.samples)[number] | undefined>(
      (least, sample) => (least && least.roundTripMs <= sample.roundTripMs ? least : sample),
      undefined,
    );
    return best && pageMs + best.offsetMs;
  }

  /** When a time of the server's clock was; undefined before the first reply. */
  dateOf(serverMs: number): Date | undefined {
    const pageMs = performance.now();
    const serverNowMs = this.at(pageMs);
    return serverNowMs === undefined ? undefined : new Date(Date.now() - (serverNowMs - serverMs));
  }
}
