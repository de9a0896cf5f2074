// SPDX-License-Identifier: Apache-2.0
// The pictures of this display: how they are asked for, and what draws them.
import { CodecChoice } from "./codec_choice";
import type { Connection } from "./connection";
import { page } from "./page";
import { PictureView, type PictureViewEvents } from "./picture_view";
import { SurfaceView, type ShownScene } from "./surface/surface_view";

const kAskMs = 1000;

export class PictureStream {
  readonly surface: SurfaceView;
  readonly view: PictureView;
  readonly codec: CodecChoice;
  private offered = false;
  private askedMs = -Infinity;

  constructor(
    scene: ShownScene,
    connection: Pick<Connection, "send">,
    events: Omit<PictureViewEvents, "unsupported" | "missing">,
  ) {
    this.surface = new SurfaceView(scene);
    this.view = new PictureView(page.canvas, page.frame, this.surface, {
      ...events,
      shown: (picture) => {
        events.shown(picture);
        this.offerSurfaces();
      },
      unsupported: () => this.codec.fallBack(),
      missing: () => this.askAgain(),
    });
    this.codec = new CodecChoice(page.codec, connection);
  }

  /** The server then sends the picture whole. Not more often than it allows. */
  private askAgain(): void {
    if (performance.now() - this.askedMs < kAskMs) return;
    this.askedMs = performance.now();
    this.codec.askAgain();
  }

  /** Only with the first picture: to begin with WebGL may take a second, in which there would be none. */
  private offerSurfaces(): void {
    if (this.offered) return;
    this.offered = true;
    window.setTimeout(() => {
      if (this.surface.works) this.codec.offerSurfaces();
    });
  }
}
