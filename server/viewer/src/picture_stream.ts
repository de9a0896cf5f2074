// SPDX-License-Identifier: Apache-2.0
// The pictures of this display: how they are asked for, and what draws them.
import { CodecChoice } from "./codec_choice";
import type { Connection } from "./connection";
import { page } from "./page";
import { PictureView, type PictureViewEvents } from "./picture_view";
import { SurfaceView, type ShownScene } from "./surface/surface_view";

export class PictureStream {
  readonly surface: SurfaceView;
  readonly view: PictureView;
  readonly codec: CodecChoice;

  constructor(scene: ShownScene, connection: Pick<Connection, "send">, events: Omit<PictureViewEvents, "filmFailed">) {
    this.surface = new SurfaceView(scene);
    this.view = new PictureView(page.canvas, page.frame, this.surface, {
      ...events,
      filmFailed: () => this.codec.fallBack(),
    });
    this.codec = new CodecChoice(page.codec, connection, this.surface.works);
  }
}
