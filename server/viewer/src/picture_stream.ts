// SPDX-License-Identifier: Apache-2.0
// The pictures of this display: how they are asked for, and what draws them.
import type { KeptVolumes } from "./cine_bar";
import { CodecChoice } from "./codec_choice";
import type { Connection } from "./connection";
import { page } from "./page";
import { PictureView, type PictureViewEvents } from "./picture_view";
import type { Size } from "./view_geometry";
import { SurfaceView, type ShownScene } from "./surface/surface_view";

const kAskMs = 1000;
const kSettledMs = 500;
/** Surfaces are tried again after this time, and each time after four times as long. */
const kRetryMs = 15_000;
/** Sizes that differ by less are one: of a page that has changed, and of a browser that is slower or quicker now. */
const [kSameSize, kSamePace] = [0.02, 0.25];
/** What a request may contain. */
const [kLeastSide, kMostSide] = [16, 4096];

export class PictureStream {
  readonly surface: SurfaceView;
  readonly view: PictureView;
  readonly codec: CodecChoice;
  /** The volumes that this display has kept. */
  readonly kept: KeptVolumes = {
    shownId: () => this.view.volumeId,
    has: (volumeId) => this.surface.has(volumeId),
    show: (volumeId) => this.view.showKept(volumeId),
    stayAt: (volumeId) => this.view.stayAt(volumeId),
    loop: (volumeId) => this.view.loop(volumeId),
    endLoop: () => this.view.endLoop(),
    endLoopAt: (volumeId) => this.view.endLoopAt(volumeId),
    setLive: (live) => this.view.setLive(live),
    frozenAt: (volumeId) => this.view.frozenAt(volumeId),
  };
  private offered = false;
  private askedMs = -Infinity;
  private askTimer = 0;
  private askedHeight = 0; // when the size has changed last
  private sizeTimer = 0; // 0: it does not run
  private sameSize = Infinity; // by how much sizes may differ that count as one
  private seenPixels = Infinity;
  private retryMs = kRetryMs;
  private retryTimer = 0;

  constructor(
    scene: ShownScene,
    connection: Pick<Connection, "send">,
    events: Omit<PictureViewEvents, "unsupported" | "noSurfaces" | "missing">,
  ) {
    this.surface = new SurfaceView(scene);
    this.view = new PictureView(page.canvas, page.frame, this.surface, {
      ...events,
      shown: (picture) => {
        events.shown(picture);
        this.offerSurfaces();
        this.watchPace();
      },
      unsupported: () => this.codec.fallBack(),
      noSurfaces: () => {
        this.codec.fallBack();
        this.offerLater();
      },
      missing: () => this.askAgain(),
    });
    this.codec = new CodecChoice(page.codec, connection, () => this.shownSize());
    new ResizeObserver(() => this.watchSize()).observe(page.frame);
    window.addEventListener("resize", () => this.watchSize()); // also of the pixels of a point
  }

  /** The pixels of the screen that the picture covers, as far as this browser lights that many. */
  private shownSize(): Size {
    const { clientWidth, clientHeight } = page.frame;
    const wanted = { width: clientWidth * devicePixelRatio, height: clientHeight * devicePixelRatio };
    const less = Math.min(1, Math.sqrt(this.surface.mostPixels / (wanted.width * wanted.height)));
    const side = (pixels: number) => Math.min(kMostSide, Math.max(kLeastSide, Math.round(less * pixels)));
    return { width: side(wanted.width), height: side(wanted.height) };
  }

  /** Asks for pictures of another size once the size has settled, and only for one that is clearly another. */
  private watchSize(sameSize = kSameSize): void {
    this.sameSize = Math.min(this.sameSize, sameSize);
    if (sameSize === kSamePace && this.sizeTimer !== 0) return; // it runs already
    window.clearTimeout(this.sizeTimer);
    this.sizeTimer = window.setTimeout(() => {
      this.sizeTimer = 0;
      const { height } = this.shownSize();
      const isSame = Math.abs(height / this.askedHeight - 1) < this.sameSize;
      this.sameSize = Infinity;
      if (isSame) return;
      this.askedHeight = height;
      this.codec.sizeChanged();
    }, kSettledMs);
  }

  /** The server then sends the picture whole. Not more often than it allows: later, where the last time was just now. */
  private askAgain(): void {
    window.clearTimeout(this.askTimer);
    const waitMs = this.askedMs + kAskMs - performance.now();
    if (waitMs > 0) return void (this.askTimer = window.setTimeout(() => this.askAgain(), waitMs));
    this.askedMs = performance.now();
    this.codec.ask();
  }

  /** How many pixels this browser can light is known after a while. */
  private watchPace(): void {
    if (this.surface.mostPixels === this.seenPixels) return;
    this.seenPixels = this.surface.mostPixels;
    this.watchSize(kSamePace);
  }

  /** A machine may be busy for a while only, and WebGL come back. */
  private offerLater(): void {
    window.clearTimeout(this.retryTimer);
    this.retryTimer = window.setTimeout(() => this.offer(), this.retryMs);
    this.retryMs *= 4;
  }

  private offer(): void {
    if (this.surface.works) this.codec.offerSurfaces();
    else this.offerLater();
  }

  /** Only with the first picture: to begin with WebGL may take a second, in which there would be none. */
  private offerSurfaces(): void {
    if (this.offered) return;
    this.offered = true;
    window.setTimeout(() => this.offer());
  }
}
