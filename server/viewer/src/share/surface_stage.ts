// SPDX-License-Identifier: Apache-2.0
// The canvas of a shared surface: drawn coarsely while something moves where the browser is slow, finely at rest.
import { create } from "@bufbuild/protobuf";
import { PictureSchema, type Picture } from "../../generated/fanlight_pb.js";
import { find } from "../element";
import type { SettingsEditor } from "../settings_editor";
import type { SurfaceView } from "../surface/surface_view";

const kRestMs = 150;
const kCamera = ["yaw", "pitch", "roll"].map((name) => `camera.${name}_deg`);

export class SurfaceStage {
  private readonly context: CanvasRenderingContext2D;
  private due = false;
  private restTimer = 0;
  private lastTurn: ReadonlyMap<string, number> = new Map();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly view: SurfaceView,
    private readonly editor: SettingsEditor,
  ) {
    this.context = canvas.getContext("2d", { alpha: false })!;
  }

  /** Shows another picture, if it is still wanted once it is unpacked. Rejects where it is damaged. */
  async show(picture: Picture, isWanted: () => boolean): Promise<void> {
    if (!this.view.showKept(picture.volumeId)) {
      const copy = create(PictureSchema, { ...picture }); // unpack() takes the maps out of it
      await this.view.unpack(copy);
      if (!isWanted()) return;
      this.view.show(copy);
    }
    if (this.canvas.width !== picture.width || this.canvas.height !== picture.height) {
      Object.assign(this.canvas, { width: picture.width, height: picture.height });
      find("#frame", HTMLElement).style.setProperty("--aspect", String(picture.width / picture.height));
    }
    this.draw(true);
  }

  /** Light or camera may have changed. */
  changed(): void {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      if (this.view.canTurn) this.lastTurn = new Map(kCamera.map((name) => [name, this.editor.number(name)]));
      else if (this.lastTurn.size > 0) this.editor.restore(new Map(this.lastTurn)); // no farther: nothing is known there
      if (this.view.isOld) this.draw(true);
    });
  }

  private draw(moving: boolean): void {
    this.view.draw(this.context, moving);
    window.clearTimeout(this.restTimer);
    if (moving) this.restTimer = window.setTimeout(() => this.view.isCoarse && this.draw(false), kRestMs);
  }
}
