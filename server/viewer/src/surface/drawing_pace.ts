// SPDX-License-Identifier: Apache-2.0
// How coarsely a picture in motion is drawn, by the time that it takes this browser: level x level pixels become one.

/** A picture in motion takes no longer, if it can be had by fewer pixels. */
const kMovingMs = 35;
/** Nor one at rest. */
const kRestMs = 400;
/** The coarsest picture has that many pixels on each side. A browser that is too slow for that lights no surfaces. */
const kLeastSide = 128;
const kTooSlowMs = 120;
const kLearnEvery = 8;
const kNewShare = 0.4;
/** One stall, of the browser or of the machine, is no pace: only several in a row count whole. */
const kMostSlower = 3;

export class DrawingPace {
  private pixelMs = 0; // of a pixel that is drawn; 0: not known
  private untilLearning = 0;

  /** For a picture of that size. */
  levelOf({ width, height }: { width: number; height: number }): number {
    const coarsest = Math.max(1, Math.floor(Math.min(width, height) / kLeastSide));
    const wanted = Math.ceil(Math.sqrt((this.pixelMs * width * height) / kMovingMs));
    return Math.min(coarsest, Math.max(1, wanted));
  }

  get isTooSlow(): boolean {
    return this.pixelMs * kLeastSide * kLeastSide > kTooSlowMs;
  }

  /** The most pixels that this browser draws at rest without a wait that is felt. */
  get mostPixels(): number {
    return this.pixelMs > 0 ? kRestMs / this.pixelMs : Infinity;
  }

  /** Whether the next picture is to be measured. Not each is: to wait for a GPU costs time. */
  get learns(): boolean {
    return --this.untilLearning <= 0;
  }

  learn({ width, height }: { width: number; height: number }, tookMs: number): void {
    const before = this.pixelMs;
    const measured = tookMs / (width * height);
    const pixelMs = before === 0 ? measured : Math.min(measured, kMostSlower * before);
    this.pixelMs = before === 0 ? pixelMs : (1 - kNewShare) * before + kNewShare * pixelMs;
    const steady = before > 0 && Math.abs(this.pixelMs / before - 1) < 0.5;
    this.untilLearning = steady ? kLearnEvery : 1;
  }
}
