// SPDX-License-Identifier: Apache-2.0
// Plays the surfaces of a file at the rate of their volumes, in a loop.
import type { Picture } from "../../generated/fanlight_pb.js";
import { find } from "../element";
import type { SurfaceStage } from "./surface_stage";

const kUsualMs = 500; // between the last picture and the first one, and where times are not known

export class Film {
  private readonly play = find("#play", HTMLButtonElement);
  private readonly place = find("#place", HTMLInputElement);
  private timer = 0;
  private shown = 0;

  constructor(
    private readonly pictures: readonly Picture[],
    private readonly stage: SurfaceStage,
    private readonly changed: () => void,
    private readonly failed: (error: Error) => void,
  ) {
    const single = pictures.length < 2;
    this.play.hidden = this.place.hidden = single;
    this.place.max = String(pictures.length - 1);
    this.play.onclick = () => (this.timer ? this.pause() : this.next());
    this.place.oninput = () => {
      this.pause();
      this.begin(this.place.valueAsNumber);
    };
  }

  start(): void {
    this.begin(0);
  }

  private begin(index: number): void {
    this.show(index).catch(this.failed);
  }

  private async show(index: number): Promise<void> {
    const picture = this.pictures[index];
    if (!picture) throw new Error("There is no surface in this file.");
    this.shown = index;
    this.place.value = String(index);
    this.changed();
    await this.stage.show(picture, () => this.shown === index);
  }

  private pause(): void {
    window.clearTimeout(this.timer);
    this.timer = 0;
    this.play.textContent = "Play";
  }

  private next(): void {
    this.play.textContent = "Pause";
    const [now, then] = [this.pictures[this.shown], this.pictures[this.shown + 1]];
    const apartMs = now && then ? Number(then.captureTimeNs - now.captureTimeNs) / 1e6 : kUsualMs;
    this.timer = window.setTimeout(
      () => {
        this.begin((this.shown + 1) % this.pictures.length);
        this.next();
      },
      apartMs > 0 ? apartMs : kUsualMs,
    );
  }
}
