// SPDX-License-Identifier: Apache-2.0
// How coarsely a picture in motion is drawn, by the time that it takes this browser: up to 4 x 4 pixels become one.

/** A picture in motion takes no longer, if it can be had by fewer pixels. */
const kMovingMs = 35;
const kCoarsest = 4;
const kTooSlowMs = 120;
const kLearnEvery = 8;
const kNewShare = 0.4;

export class DrawingPace {
  private fullMs = 0; // of a picture with all its pixels
  private untilLearning = 0;

  get level(): number {
    return Math.min(kCoarsest, Math.max(1, Math.ceil(Math.sqrt(this.fullMs / kMovingMs))));
  }

  get isTooSlow(): boolean {
    return this.fullMs / (kCoarsest * kCoarsest) > kTooSlowMs;
  }

  /** Whether the next picture is to be measured. Not each is: to wait for a GPU costs time. */
  get learns(): boolean {
    return --this.untilLearning <= 0;
  }

  learn(level: number, tookMs: number): void {
    const before = this.level;
    const fullMs = tookMs * level * level;
    this.fullMs = this.fullMs === 0 ? fullMs : (1 - kNewShare) * this.fullMs + kNewShare * fullMs;
    this.untilLearning = this.level === before ? kLearnEvery : 1;
  }
}
