// SPDX-License-Identifier: Apache-2.0
// The pictures of this display: how they are asked for, and what draws them.
import type { Picture } from "../generated/fanlight_pb.js";
import { CodecChoice } from "./codec_choice";
import type { Connection } from "./connection";
import { page } from "./page";
import { PictureView } from "./picture_view";
import type { SceneValues } from "./surface/light_parameters";
import { SurfaceView } from "./surface/surface_view";

export interface PictureStreamEvents {
  shown(picture: Picture): void;
  unreadable(sentence: string): void;
}

export class PictureStream {
  readonly surface: SurfaceView;
  readonly view: PictureView;
  readonly codec: CodecChoice;

  constructor(scene: SceneValues, connection: Pick<Connection, "send">, events: PictureStreamEvents) {
    this.surface = new SurfaceView(scene);
    this.view = new PictureView(page.canvas, page.frame, this.surface, {
      ...events,
      filmFailed: () => this.codec.fallBack(),
    });
    this.codec = new CodecChoice(page.codec, connection, this.surface.works);
  }
}
